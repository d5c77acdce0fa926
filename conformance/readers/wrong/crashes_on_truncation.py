#!/usr/bin/python3 -IS
# caught by: cut
"""Ends with a signal where bytes are missing."""
import os
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.check


def check(ok, at, rule, message):
    if not ok and rule in ("H1", "C3", "F1", "O3"):
        os.abort()
    right(ok, at, rule, message)


t4d_reader.check = check

sys.exit(t4d_reader.main(sys.argv[1:]))
