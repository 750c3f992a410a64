#!/usr/bin/env python3
"""A viewer's file, read by other programs: check.py FOLDER_OF_SCHEMAS FILE

Reads the file with PyPI's mcap, by its index; holds every message against the schema in the file and, where the folder has one, against
the schema of Foxglove; and follows the arm of the URDF, joint by joint, to the frames that the file has. Prints as JSON the number of
messages by topic and the largest difference between a frame and where the URDF has it.
"""

import json
import math
import pathlib
import sys
import xml.etree.ElementTree as ET

import jsonschema
from mcap.reader import make_reader


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def turn(axis, angle):
    """Rodrigues, as a homogeneous matrix."""
    x, y, z = axis
    s, c = math.sin(angle), math.cos(angle)
    v = 1 - c
    return [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0],
        [0, 0, 0, 1],
    ]


def shift(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def numbers(text):
    return [float(word) for word in text.split()]


def joints(urdf):
    """(name, type, parent, child, origin, axis) of every joint."""
    for joint in ET.fromstring(urdf).findall("joint"):
        origin = joint.find("origin")
        roll, pitch, yaw = numbers(origin.get("rpy"))
        place = shift(*numbers(origin.get("xyz")))
        for axis, angle in (((0, 0, 1), yaw), ((0, 1, 0), pitch), ((1, 0, 0), roll)):
            place = product(place, turn(axis, angle))
        axis = joint.find("axis")
        ends = joint.find("parent").get("link"), joint.find("child").get("link")
        yield joint.get("name"), joint.get("type"), *ends, place, numbers(axis.get("xyz")) if axis is not None else None


def placed(joint, q):
    _, kind, _, _, origin, axis = joint
    if kind == "fixed":
        return origin
    move = shift(*(q * x for x in axis)) if kind == "prismatic" else turn(axis, q)
    return product(origin, move)


def matrix(transform):
    """The homogeneous matrix of a translation and a quaternion."""
    t, r = transform["translation"], transform["rotation"]
    x, y, z, w = r["x"], r["y"], r["z"], r["w"]
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t["x"]],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t["y"]],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t["z"]],
        [0, 0, 0, 1],
    ]


def main(folder, path):
    official = {f"foxglove.{file.stem}": json.loads(file.read_text()) for file in pathlib.Path(folder).glob("*.json")}
    validators, counts, arm, state, worst = {}, {}, [], {}, 0.0
    with open(path, "rb") as stream:
        reader = make_reader(stream)
        assert reader.get_summary() is not None, "no summary"
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json"), channel.topic
            if schema.id not in validators:
                own = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(own)
                all_schemas = [own] + ([official[schema.name]] if schema.name in official else [])
                validators[schema.id] = [jsonschema.Draft202012Validator(each) for each in all_schemas]
            body = json.loads(message.data, parse_constant=lambda word: sys.exit(f"{channel.topic}: {word} is no JSON"))
            for validator in validators[schema.id]:
                validator.validate(body)
            if "timestamp" in body:
                stamp = body["timestamp"]["sec"] * 10**9 + body["timestamp"]["nsec"]
                assert stamp == message.log_time, channel.topic
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
            if channel.topic == "/robot_description":
                arm = list(joints(body["data"]))
            elif channel.topic == "/joint_states":
                state = {joint["name"]: joint.get("position") for joint in body["joints"]}
            elif channel.topic == "/tf":
                assert [joint[2:4] for joint in arm] == [
                    (each["parent_frame_id"], each["child_frame_id"]) for each in body["transforms"]
                ]
                for joint, each in zip(arm, body["transforms"]):
                    wanted, found = placed(joint, state.get(joint[0], 0.0)), matrix(each)
                    worst = max([worst] + [abs(wanted[i][j] - found[i][j]) for i in range(3) for j in range(4)])
    print(json.dumps({"messages": counts, "official": sorted(official), "worst": worst}))


if __name__ == "__main__":
    main(*sys.argv[1:])
