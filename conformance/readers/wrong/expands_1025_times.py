#!/usr/bin/python3 -IS
# caught by: invalid/A9-a-byte-more-than-1024-times
"""Decompresses to 1,025 times as many bytes (A9)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("size <= 1024 * len(block)",
                      "size <= 1025 * len(block)"))

sys.exit(reader.main(sys.argv[1:]))
