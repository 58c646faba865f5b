"""The modules of lumview's page, as the build brings them: cmake/modules.cmake at a registry of this test's."""
import base64
import hashlib
import http.server
import io
import json
import pathlib
import shutil
import subprocess
import tarfile
import threading
import unittest

from support import PATIENCE_S, Folder

HERE = pathlib.Path(__file__).resolve().parent
HOST = "linux-x64"
SCRIPT = """cmake_minimum_required(VERSION 3.22)
set(CMAKE_HOST_SYSTEM_NAME {system})
set(CMAKE_HOST_SYSTEM_PROCESSOR {processor})
set(lum_view_page {folder}/page)
set(lum_view_modules {folder}/there/node_modules)
include({modules})
{code}
"""


def archive(name, version):
    """A module as a registry has it."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:gz") as tar:
        for path, text in (("package.json", json.dumps({"name": name, "version": version})), ("code.js", name)):
            info = tarfile.TarInfo(f"package/{path}")
            info.size = len(text)
            tar.addfile(info, io.BytesIO(text.encode()))
    return out.getvalue()


class Registry(http.server.ThreadingHTTPServer):
    def __init__(self, files):
        self.files, self.asked = files, []
        super().__init__(("127.0.0.1", 0), Answer)
        self.url = f"http://127.0.0.1:{self.server_port}"
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Answer(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.server.asked.append(self.path)
        body = self.server.files.get(self.path)
        self.send_response(503 if body is None else 200)
        self.send_header("Content-Length", str(len(body or b"")))
        self.end_headers()
        self.wfile.write(body or b"")

    def log_message(self, *_):
        pass


class Modules(unittest.TestCase):
    names = {"three": "0.1.0", f"@esbuild/{HOST}": "2.0.0", "@esbuild/aix-ppc64": "2.0.0"}

    def setUp(self):
        self.folder = Folder(self)
        self.archives = {name: archive(name, version) for name, version in self.names.items()}
        self.registry = Registry({f"/{name}/-/{name.split('/')[-1]}-{version}.tgz": self.archives[name]
                                  for name, version in self.names.items()})
        self.addCleanup(self.registry.server_close)
        self.addCleanup(self.registry.shutdown)
        known = {}
        for name, version in self.names.items():
            digest = base64.b64encode(hashlib.sha512(self.archives[name]).digest()).decode()
            known[name] = {"version": version, "integrity": f"sha512-{digest}"}
        page = self.folder / "page"
        page.mkdir()
        (page / "modules.json").write_text(json.dumps(known))
        self.there = self.folder / "there/node_modules"

    def cmake(self, code, *options, system="Linux", processor="x86_64", **environment):
        """What a function of modules.cmake says is wrong."""
        script = self.folder / "script.cmake"
        code += '\nfile(WRITE "${lum_view_page}/said" "${wrong}")'
        script.write_text(SCRIPT.format(folder=self.folder / "", modules=HERE / "../../cmake/modules.cmake", code=code,
                                        system=system, processor=processor))
        path = shutil.os.environ["PATH"]
        r = subprocess.run([shutil.which("cmake"), *options, "-P", script], capture_output=True, text=True, timeout=PATIENCE_S,
                           env={"PATH": path, "HOME": str(self.folder / ""), **environment})
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return (self.folder / "page/said").read_text()

    def fetch(self, **options):
        return self.cmake("lum_fetch_without_npm(wrong)", **{"NPM_CONFIG_REGISTRY": self.registry.url, **options})

    def test_without_npm_they_come_from_the_registry_as_the_list_names_them(self):
        for option in ("NPM_CONFIG_REGISTRY", "npm_config_registry"):
            self.assertEqual(self.cmake("lum_fetch_without_npm(wrong)", **{option: self.registry.url + "/"}), "")
            found = {str(p.parent.relative_to(self.there)): p.read_text() for p in self.there.glob("**/code.js")}
            self.assertEqual(found, {n: n for n in ("three", f"@esbuild/{HOST}")})
            self.assertEqual({p.name for p in self.there.iterdir()}, {"three", "@esbuild"})

    @unittest.skipUnless(shutil.which("node"), "node is not here")
    def test_what_is_configured_for_npm_tells_the_registry(self):
        reader = self.folder / "index.js"
        reader.write_text(f"module.exports = () => '{self.registry.url}/';\n")
        options = ("-DLUM_NODE=" + shutil.which("node"), f"-DLUM_REGISTRY_URL={reader}")
        self.assertEqual(self.cmake("lum_fetch_without_npm(wrong)", *options), "")
        self.assertTrue((self.there / "three/code.js").exists())

    def test_every_hash_is_read(self):
        for i in range(40):
            raw = hashlib.sha512(b"%d" % i).digest()
            text = base64.b64encode(raw).decode()
            self.assertEqual(self.cmake(f'lum_decode(wrong "{text}")'), raw.hex())

    def test_what_is_another_than_the_list_names_is_refused(self):
        self.registry.files["/three/-/three-0.1.0.tgz"] = archive("three", "0.1.0 with something more")
        self.assertEqual(self.fetch(), f"{self.registry.url}/three/-/three-0.1.0.tgz is not what modules.json names: "
                                       f"its SHA-512 differs: {self.how()}")
        self.assertFalse((self.there / "three").exists())

    def how(self):
        return self.cmake("set(wrong ${lum_how_to_bring})")

    def test_where_nothing_answers_it_is_said_how_they_are_brought(self):
        self.assertIn("LUM_VIEW_MODULES=FOLDER", self.how())
        self.registry.shutdown()
        self.registry.server_close()
        said = self.fetch()
        self.assertTrue(said.startswith(f"{self.registry.url}/three/-/three-0.1.0.tgz: "), said)
        self.assertTrue(said.endswith(self.how()), said)

    def test_without_a_registry_it_is_said_which_can_be_named(self):
        said = self.cmake("lum_fetch_without_npm(wrong)", "-DLUM_NODE=OFF")
        self.assertTrue(said.startswith("missing: npm (Debian: npm), or the name of its registry"), said)
        self.assertIn("NPM_CONFIG_REGISTRY=URL", said)

    def test_a_host_without_esbuild_is_told(self):
        self.assertEqual(self.fetch(system="Plan9", processor="mips"), "esbuild has no program for plan9-mips")

    def test_hosts_are_named_as_esbuild_names_its_programs(self):
        known = json.loads((HERE / "../../tools/lumview/page/modules.json").read_text())
        for system, processor, name in (("Linux", "x86_64", "linux-x64"), ("Linux", "aarch64", "linux-arm64"),
                                        ("Linux", "armv7l", "linux-arm"), ("Linux", "i686", "linux-ia32"),
                                        ("Linux", "ppc64le", "linux-ppc64"), ("Linux", "riscv64", "linux-riscv64"),
                                        ("Linux", "s390x", "linux-s390x"), ("Darwin", "arm64", "darwin-arm64"),
                                        ("Darwin", "x86_64", "darwin-x64"), ("FreeBSD", "amd64", "freebsd-x64")):
            self.assertEqual(self.cmake("lum_name_host(wrong)", system=system, processor=processor), name)
            self.assertIn(f"@esbuild/{name}", known)

    @unittest.skipUnless(shutil.which("npm"), "npm is not here")
    def test_npm_asks_no_more_than_twice(self):
        """By itself it asks three times, ten seconds and a minute apart."""
        self.registry.files.clear()
        said = self.cmake("lum_fetch_with_npm(wrong)", f"-DLUM_NPM={shutil.which('npm')}",
                          npm_config_registry=self.registry.url, npm_config_cache=str(self.folder / "cache"))
        self.assertTrue(said.startswith("npm could not fetch the modules of its page ("), said)
        self.assertTrue(said.endswith(self.how()), said)
        self.assertTrue(self.registry.asked)
        for path in set(self.registry.asked):
            self.assertLessEqual(self.registry.asked.count(path), 2, path)

    def test_a_folder_that_is_brought_is_looked_into(self):
        self.assertEqual(self.fetch(), "")
        check = "lum_check_modules(wrong)"
        self.assertEqual(self.cmake(check), "")
        (self.there / "three/package.json").write_text('{"version": "0.2.0"}')
        self.assertEqual(self.cmake(check), f"no three 0.1.0 is in {self.there}: {self.how()}")
        shutil.rmtree(self.there / "three")
        self.assertEqual(self.cmake(check), f"no three 0.1.0 is in {self.there}: {self.how()}")

    def test_with_an_esbuild_of_the_system_a_release_needs_its_modules_alone(self):
        esbuild = "-DLUM_ESBUILD=/usr/bin/esbuild"
        self.assertEqual(self.cmake("lum_fetch_without_npm(wrong)", esbuild, NPM_CONFIG_REGISTRY=self.registry.url), "")
        self.assertEqual([p.name for p in self.there.iterdir()], ["three"])
        self.assertEqual(self.cmake("lum_check_modules(wrong)", esbuild), "")
        self.assertIn(f"no @esbuild/{HOST} 2.0.0 is in", self.cmake("lum_check_modules(wrong)"))


if __name__ == "__main__":
    unittest.main()
