#!/usr/bin/python3 -IS
# caught by: valid/names-beside-forbidden-ones
"""Forbids names that have U+00A0, which comes after the last control."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("0x7F <= i <= 0x9F",
                      "0x7F <= i <= 0xA0"))

sys.exit(reader.main(sys.argv[1:]))
