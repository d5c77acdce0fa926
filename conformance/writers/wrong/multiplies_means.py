#!/usr/bin/python3 -IS
# caught by: means
"""Multiplies by the reciprocal instead of dividing."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

mean = t4d_writer.mean


def multiplied(sources):
    return tuple(number * (1 / len(sources)) for number in (sum(column) for column in zip(*sources)))


t4d_writer.mean = multiplied

t4d_writer.main(sys.argv[1:])
