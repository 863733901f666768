"""The command `plymotion schema`: JSON schemas of input files, by which editors complete them."""

import argparse
import json

from ..inputs.json_schema import json_schema


def run_schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of a kind of file."""
    print(json.dumps(json_schema(options.kind), indent=1))
    return 0
