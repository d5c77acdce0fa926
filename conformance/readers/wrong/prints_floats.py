#!/usr/bin/python3 -IS
# caught by: valid
"""Prints numbers as JSON numbers instead of strings."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.json.dumps


def numbers(value):
    if isinstance(value, dict):
        return {key: each if key == "name" else numbers(each) for key, each in value.items()}
    if isinstance(value, list):
        return [numbers(each) for each in value]
    if isinstance(value, str) and "0x" in value:
        return float.fromhex(value)
    return value


t4d_reader.json.dumps = lambda value, **options: right(numbers(value), **options)

sys.exit(t4d_reader.main(sys.argv[1:]))
