"""Files that a stranger may have made, read as data: nothing in them is run, and sizes are checked before reading.

Every file of the suite is read here: levels, plans, hyperparameters, tables of chances, policies, logs.
"""

from pnt_gym.reading.archives import MOST_NUMBERS, archive, arrays_of
from pnt_gym.reading.files import AccessError, ReadError, bytes_of, json_of, lines_of, opened, parsed_json, text_of
from pnt_gym.reading.plain_yaml import PlainLoader, number_of, parsed_yaml, yaml_of, yaml_text

__all__ = [
    "MOST_NUMBERS",
    "AccessError",
    "PlainLoader",
    "ReadError",
    "archive",
    "arrays_of",
    "bytes_of",
    "json_of",
    "lines_of",
    "number_of",
    "opened",
    "parsed_json",
    "parsed_yaml",
    "text_of",
    "yaml_of",
    "yaml_text",
]
