#!/usr/bin/python3 -IS
# caught by: invalid/S12-pose
"""Looks a part further back than is allowed, for poses (S12)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("max(0, end - 16 * len(bodies)):end]",
                      "max(0, end - 16 * len(bodies) - (each is poses)):end]"))

sys.exit(reader.main(sys.argv[1:]))
