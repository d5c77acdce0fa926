#!/usr/bin/python3 -IS
# caught by: valid/layers-of-one-vertex
"""Refuses a layer of one vertex."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("check(positions.rows > 0,",
                      "check(positions.rows > 1,"))

sys.exit(reader.main(sys.argv[1:]))
