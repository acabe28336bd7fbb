"""Code for other processors than this one, made in a process of its own: LLVM ends it on some errors of theirs."""

import subprocess
import sys
from typing import Literal

from vibrocap.numerics.compiler import cache, own_source
from vibrocap.numerics.compiler.machine import Target, assembly, object_code

Form = Literal["assembly", "object"]


def foreign_code(text: str, target: Target, form: Form, mark: bytes) -> bytes:
    """Code of a text in LLVM's language, as the text of an assembler or as an object file; from the disk or made now.

    mark: what such code holds; kept code without it is made anew
    Raises RuntimeError, with LLVM's own words, where it makes none.
    """
    name = cache.key(target.name, own_source(), form, text)
    code = cache.kept(name)
    if code is None or mark not in code:
        # -P: its modules do not come from the working folder
        command = [sys.executable, "-P", "-m", __name__, form, target.triple, target.processor, target.features]
        done = subprocess.run(command, input=text.encode(), capture_output=True, check=False)
        if done.returncode != 0:
            message = done.stderr.decode(errors="replace")[-2000:]
            raise RuntimeError(f"LLVM made no code for {target.triple}: {message}")
        code = done.stdout
        cache.keep(name, code)
    return code


if __name__ == "__main__":
    wanted, *rest = sys.argv[1:]
    source, target = sys.stdin.read(), Target(*rest)
    if wanted == "assembly":
        sys.stdout.buffer.write(assembly(source, target).encode())
    else:
        sys.stdout.buffer.write(object_code(source, target))
