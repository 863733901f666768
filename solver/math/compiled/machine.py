"""Object code by LLVM, without Numba: from modules to bytes, from bytes to addresses."""

import contextlib
import struct
from functools import cache
from typing import Any

import llvmlite.binding as llvm

_SYMBOLS = 2  # kind of a section in ELF


@cache
def _target_machine() -> Any:
    """Return LLVM's code generator for this CPU; addresses of 64 bits, wherever code is loaded."""
    with contextlib.suppress(RuntimeError):  # sin, cos, pow; part of libc elsewhere
        llvm.load_library_permanently("libm.so.6")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=3,
        reloc="static" if llvm.get_default_triple().startswith("x86") else "default",
        codemodel="jitdefault",
        jit=True,
    )


@cache
def _engine() -> Any:
    """Return the place where object code is loaded, for good."""
    empty = llvm.parse_assembly("")
    empty.triple = llvm.get_process_triple()
    return llvm.create_mcjit_compiler(empty, _target_machine())


def emitted(modules: list[str], exported: str) -> tuple[bytes, list[str]]:
    """Return object code of modules of LLVM that belong together, and the symbols that it needs.

    Only the function `exported` is seen from outside; all others become part of it.
    """
    whole = llvm.parse_assembly(modules[0])
    for text in modules[1:]:
        whole.link_in(llvm.parse_assembly(text))
    for function in whole.functions:
        if not function.is_declaration and function.name != exported:
            function.linkage = "internal"
    for variable in whole.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    tuning = llvm.create_pipeline_tuning_options(3)
    # Loops are over few modes and rows: ready for vectors they are slower, and take long to compile
    tuning.loop_vectorization = tuning.slp_vectorization = False
    builder = llvm.create_pass_builder(_target_machine(), tuning)
    # Nor are they long enough to be taken eight turns at a time. This is an option of the process.
    llvm.set_option("", "-unroll-runtime=false")
    builder.getModulePassManager().run(whole, builder)
    llvm.set_option("", "-unroll-runtime=true")
    code = _target_machine().emit_object(whole)
    return code, undefined(code)


def undefined(code: bytes) -> list[str]:
    """Return the symbols that object code in the ELF format needs.

    What LLVM declares says less: instructions for which the CPU has none become calls.

    Raises ValueError : another format
    """
    if code[:6] != b"\x7fELF\x02\x01":
        raise ValueError("object code in another format than ELF, 64 bits")
    (start,) = struct.unpack_from("<Q", code, 0x28)
    size, count = struct.unpack_from("<HH", code, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + size * k) for k in range(count)]
    symbols = []
    for _, kind, _, _, begin, length, link, _, _, entry in sections:
        if kind != _SYMBOLS:
            continue
        names = sections[link][4]
        for at in range(begin + entry, begin + length, entry):
            name, _, _, section, _, _ = struct.unpack_from("<IBBHQQ", code, at)
            if section == 0:
                symbols.append(code[names + name : code.index(b"\0", names + name)].decode())
    return symbols


def available(symbol: str) -> bool:
    """Return whether a library of this process has a symbol."""
    _target_machine()  # with the libraries that it takes
    return bool(llvm.address_of_symbol(symbol))


def add(code: bytes) -> None:
    """Add object code; what it needs is there before an address is asked for."""
    _engine().add_object_file(llvm.object_file.ObjectFileRef.from_data(code))


def address(symbol: str) -> int:
    """Load all object code that was added; return the address of a symbol in it."""
    engine = _engine()
    engine.finalize_object()
    return int(engine.get_function_address(symbol))
