#!/usr/bin/python3 -IS
# caught by: valid/names-beside-forbidden-ones
"""Forbids names that have U+202F, which comes after the last that is forbidden."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("0x202A <= i <= 0x202E",
                      "0x202A <= i <= 0x202F"))

sys.exit(reader.main(sys.argv[1:]))
