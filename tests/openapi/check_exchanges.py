#!/usr/bin/python3
"""check_exchanges.py OPENAPI.json EXCHANGES.jsonl: a second opinion, python3-jsonschema's, on every
answer that the tests recorded (tests/server/openapi_check.h): is its path, method, status and type
described, and does its body have the schema? Prints what does not hold; exits nonzero then."""
import json
import re
import sys

import jsonschema

document = json.load(open(sys.argv[1], encoding="utf-8"))
jsonschema.Draft202012Validator.check_schema(document["components"]["schemas"])
resolver = jsonschema.RefResolver("", document)


def pattern(path):
    """Literal parts before parameters: /v1/bakes:check is no bake."""
    expression = "".join(
        "[^/:]+" if part.startswith("{") else re.escape(part)
        for part in re.split(r"(\{[^}]*\})", path)
    )
    return path.count("{"), re.compile(expression + r"\Z")


patterns = sorted(((*pattern(path), path) for path in document["paths"]), key=lambda entry: entry[0])


def resolved(node):
    while "$ref" in node:
        node = resolver.resolve(node["$ref"])[1]
    return node


def problems(exchange):
    target = exchange["target"].split("?")[0]
    path = next((path for _, expression, path in patterns if expression.match(target)), None)
    operation = document["paths"].get(path, {}).get(exchange["method"].lower())
    if operation is None:
        return  # 404 and 405 of paths that are not there
    responses = operation["responses"]
    response = responses.get(str(exchange["status"]))
    if response is None and exchange["status"] >= 400:
        response = responses.get("default")
    if response is None:
        yield "is not described"
        return
    content = resolved(response).get("content", {})
    kind = exchange["type"].split(";")[0]
    if exchange["body"] and kind not in content:
        yield f"is of type {kind}"
    elif kind.endswith("json") and exchange["method"] != "HEAD":
        schema = content[kind]["schema"]
        validator = jsonschema.Draft202012Validator(schema, resolver=resolver)
        for error in validator.iter_errors(json.loads(exchange["body"])):
            yield f"{error.json_path}: {error.message[:300]}"


count = 0
seen = set()
wrong = 0
for line in open(sys.argv[2], encoding="utf-8"):
    exchange = json.loads(line)
    count += 1
    seen.add((exchange["method"], exchange["status"]))
    for problem in problems(exchange):
        wrong += 1
        print(exchange["method"], exchange["target"], exchange["status"], problem)
print(f"{count} answers, {len(seen)} kinds of method and status, {wrong} problems")
sys.exit(wrong > 0 or count == 0)
