"""One file for each format of another code: what it reads, and what it writes.

A file that writes has

    SUFFIX                      of the new file, such as ".uff"
    write(package, out, source) writes a ModalPackage, read from the path `source`, to the path
                                `out`; returns a remark for the user; InputError: it cannot

and `export --to NAME` has its name. A file that reads has `read(files)`, which returns a FreeBody,
or `read_modes(files)`, which returns a ModalBody; its name is a `Source` of import_table.py.
"""
