"""docs/scene.md agrees with `tyndall schema`.

    scene_reference.py [--write]      --write writes the file
"""
import json
import os
import pathlib
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parents[2]
program = os.environ.get("TYNDALL_BINARY", root / "build/release/tyndall")
page = root / "docs/scene.md"
schema = json.loads(subprocess.run([program, "schema"], check=True, capture_output=True, text=True).stdout)
seen = {}  # first place of kinds that occur in several places


def number(x):
    return f"{x:g}" if abs(x) < 1e6 else f"{x:.0e}".replace("e+0", "e").replace("e+", "e")


def kind(node):
    if "const" in node:
        return json.dumps(node["const"])
    if "enum" in node:
        return ", ".join(f"`{word}`" for word in node["enum"])
    if "anyOf" in node:
        return " or ".join(kind(one) for one in node["anyOf"])
    if "oneOf" in node:
        return "one of those below"
    type_name = node.get("type", "")
    if type_name == "array":
        count = f"{node['minItems']} " if node.get("minItems") == node.get("maxItems") and "minItems" in node else ""
        return f"{count}of: {kind(node['items'])}" if "properties" not in node["items"] else "list of those below"
    if type_name in ("number", "integer"):
        low, high = node.get("minimum", node.get("exclusiveMinimum")), node.get("maximum", node.get("exclusiveMaximum"))
        word = "integer" if type_name == "integer" else "number"
        if low is None and high is None:
            return word
        opens, closes = "(" if "exclusiveMinimum" in node else "[", ")" if "exclusiveMaximum" in node else "]"
        return f"{word} in {opens}{number(low) if low is not None else '-inf'}, {number(high) if high is not None else 'inf'}{closes}"
    return {"object": "those below", "string": "text", "boolean": "true, false"}.get(type_name, type_name)


def table(node, lines):
    rows = []
    for key, value in node.get("properties", {}).items():
        if key == "type" and "const" in value:
            continue
        default = "required" if key in node.get("required", []) else \
            f"`{json.dumps(value['default'])}`" if "default" in value else ""
        rows.append(f"| `{key}` | {kind(value)} | {default} | {value.get('description', '')} |".replace("||", "| |"))
    if rows:
        lines += ["| key | value | default | |", "|---|---|---|---|", *rows, ""]
    for limit in node.get("allOf", []):
        both = limit.get("not", {}).get("required")
        if both:
            lines += ["Not together: " + ", ".join(f"`{key}`" for key in both) + ".", ""]


def section(path, node, lines):
    """Writes everything below a key."""
    variants = node.get("oneOf")
    if variants:
        text = json.dumps(variants)
        if text in seen:
            lines += [f"## {path}", "", f"{node.get('description', '')}. As `{seen[text]}`.".lstrip(". "), ""]
            return
        seen[text] = path
        lines += [f"## {path}", "", node.get("description", ""), ""]
        for variant in variants:
            word = variant.get("properties", {}).get("type", {})
            lines += [f"**`{word.get('const', '')}`** {word.get('description', '')}", ""]
            table(variant, lines)
        for variant in variants:
            below(path, variant, lines)
        return
    if node.get("type") == "object":
        lines += [f"## {path}", "", node.get("description", ""), ""]
        table(node, lines)
        below(path, node, lines)
    elif node.get("type") == "array" and ("properties" in node["items"] or "oneOf" in node["items"]):
        section(path + "[]", {"description": node.get("description", ""), **node["items"]}, lines)


def below(path, node, lines):
    for key, value in node.get("properties", {}).items():
        section(f"{path}.{key}" if path else key, value, lines)


lines = ["# Scenes, key by key", "",
         "Made of `tyndall schema` by `tests/guards/scene_reference.py --write`; a test compares. JSON with comments; lengths",
         "are in scene units, colours linear RGB or one number for grey. `tyndall defaults` prints a scene with all of it.", ""]
table(schema, lines)
below("", schema, lines)
text = "\n".join(line.rstrip() for line in lines).rstrip() + "\n"
while "\n\n\n" in text:
    text = text.replace("\n\n\n", "\n\n")
if sys.argv[1:] == ["--write"]:
    page.write_text(text)
elif page.read_text() != text:
    sys.exit("docs/scene.md is not what `tyndall schema` says: run tests/guards/scene_reference.py --write")
else:
    print(f"docs/scene.md: {text.count('| `')} keys")
