"""Logs read with other people's readers: whole ones, and those that lack their end."""

import io

from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader


def messages(path):
    """{topic: [(log time [ns], data)]} of a whole log."""
    found = {}
    with open(path, "rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, message.data))
    return found


def messages_of_a_cut_log(path):
    """The same from a log that lacks its end, read in one pass."""
    found, topics = {}, {}
    try:
        for record in StreamReader(io.BytesIO(path.read_bytes())).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            if isinstance(record, Message):
                found.setdefault(topics[record.channel_id], []).append((record.log_time, record.data))
    except EndOfFile:
        pass
    return found
