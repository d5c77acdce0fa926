#!/usr/bin/python3 -IS
# caught by: invalid/M11-three-parents-in-a-circle
"""Looks at the parent of a body, and not at the parent of that (M11)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("            while path[-1] not in rooted:",
                      "            if path[-1] not in rooted:"))

sys.exit(reader.main(sys.argv[1:]))
