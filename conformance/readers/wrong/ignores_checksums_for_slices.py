#!/usr/bin/python3 -IS
# caught by: flip
"""Compares no checksum for a slice."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.check
right_slice_at = t4d_reader.slice_at


def check(ok, at, rule, message):
    right(ok or rule in ("H2", "C4", "C5", "C10", "F2", "F6"), at, rule, message)


def slice_at(file, plane):
    t4d_reader.check = check
    try:
        return right_slice_at(file, plane)
    finally:
        t4d_reader.check = right


t4d_reader.slice_at = slice_at

sys.exit(t4d_reader.main(sys.argv[1:]))
