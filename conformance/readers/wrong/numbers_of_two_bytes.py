#!/usr/bin/python3 -IS
# caught by: valid/zstd-repeats-of-large-numbers
"""Reads two bytes of the numbers of codec 2 that are not repeated."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("            z = next(stored)",
                      "            z = next(stored) & 0xFFFF"))

sys.exit(reader.main(sys.argv[1:]))
