#!/usr/bin/python3 -IS
# caught by: plain
"""Stores positions as binary32."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

t4d_writer.POSITIONS = 9

t4d_writer.main(sys.argv[1:])
