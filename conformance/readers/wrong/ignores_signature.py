#!/usr/bin/python3 -IS
# caught by: invalid
"""Takes any eight bytes for the signature."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.check


def check(ok, at, rule, message):
    right(ok or rule == "H1", at, rule, message)


t4d_reader.check = check

sys.exit(t4d_reader.main(sys.argv[1:]))
