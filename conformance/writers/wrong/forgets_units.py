#!/usr/bin/python3 -IS
# caught by: head
"""Writes no units and no details."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

t4d_writer.NOT_IN_HEAD += "length_unit", "time_unit", "details"

t4d_writer.main(sys.argv[1:])
