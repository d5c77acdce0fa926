#!/usr/bin/python3 -IS
# caught by: valid
"""Waits for an index that the file does not have."""
import sys
import time

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.read_file_header


def read_file_header(file):
    version, has_index = right(file)
    while not has_index:
        time.sleep(1)
    return version, has_index


t4d_reader.read_file_header = read_file_header

sys.exit(t4d_reader.main(sys.argv[1:]))
