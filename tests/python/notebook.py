"""notebook IN OUT: executes a notebook, each cell within a minute, in a folder of its own, and writes it with its outputs.
Fails at the first cell that raises, and shows it."""
import pathlib
import re
import sys
import tempfile

import jupyter_client.manager
import nbclient
import nbformat


def main(given, made):
    notebook = nbformat.read(given, as_version=4)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as sockets:

        class Manager(jupyter_client.manager.AsyncKernelManager):
            """Talks to the kernel over sockets that nobody else can reach."""

            def __init__(self, **options):
                super().__init__(transport="ipc", connection_file=f"{sockets}/kernel.json", **options)

        client = nbclient.NotebookClient(notebook, kernel_manager_class=Manager, kernel_name="python3", timeout=600,
                                         resources={"metadata": {"path": folder}})
        try:
            client.execute()
        except nbclient.exceptions.CellExecutionError as error:
            sys.exit(re.sub(r"\x1b\[[0-9;]*m", "", f"{given}: a cell fails\n{error}"))
    nbformat.write(notebook, pathlib.Path(made))


if __name__ == "__main__":
    main(*sys.argv[1:])
