#!/usr/bin/python3 -IS
# caught by: valid/head-of-16-MiB
"""Refuses a HEAD of 16 MiB, which is as long as it can be (M1)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("len(data) <= 16 << 20",
                      "len(data) < 16 << 20"))

sys.exit(reader.main(sys.argv[1:]))
