#!/usr/bin/python3 -IS
# caught by: flip
"""Compares no checksum."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.check


def check(ok, at, rule, message):
    right(ok or rule in ("H2", "C4", "C5", "C10", "F2", "F6"), at, rule, message)


t4d_reader.check = check

sys.exit(t4d_reader.main(sys.argv[1:]))
