# SPDX-License-Identifier: Apache-2.0
"""Builds the site with mkdocs-material: rewrites the pages for Python-Markdown, writes the configuration, and removes
the parts of the theme that need a network.

The pages are written for GitHub. Python-Markdown differs: lists and tables need a blank line before them, the text of
list items needs four spaces, and headings get other anchors. So the pages are rewritten, and each heading names its
anchor.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

from markdown_pages import (ATTRIBUTE, CODE_SPAN, COMMENT, FENCE, FOLDERS, HEADING, LINK, REFERENCE, Anchors, Page,
                            changed_outside_fences, folder_of, page_names)

HERE = pathlib.Path(__file__).resolve().parent
TITLES = {"tutorials": "Tutorials", "how-to": "How to", "reference": "Reference", "explanation": "Explanation",
          "evidence": "Evidence", "contributing": "Contributing"}
# The order of pages in the navigation. All other pages follow, sorted by title.
ORDER = {
    "tutorials": ("engine_mips", "gltf_model", "lobes_in_three", "ci_job", "farm", "ray_traced_textures"),
    "how-to": ("green_is_wrong", "choose_lobes", "does_my_map_gain", "reduce_memory", "terrain_and_udim",
               "export_to_engine", "web_engines", "unreal", "unity", "godot", "o3de", "blender", "draw_lobes",
               "plain_pyramids", "error_numbers", "service_behind_proxy", "clusters", "install_packages", "upgrade",
               "caches_and_removal"),
    "reference": ("commands", "exit_codes", "input_maps", "file_format", "lobe_textures", "gltf", "scenes", "manifests",
                  "animation_jobs", "inferred_textures", "packed_fields", "service", "c_and_python", "glossary"),
    "explanation": ("how_it_works", "accuracy", "limits"),
}
# Name, title, roughness and metalness of the materials on the first page.
LIVE_MATERIALS = (("hammered", "Hammered metal", 0.22, 1), ("car-paint", "Car paint", 0.28, 1),
                  ("bricks", "Bricks", 0.7, 0))
LIVE_SIZE = 256
LIVE_FRAME = """
Move the divider, turn the sphere, and compare with the reference:

<iframe class="live" title="Materials, drawn from lobes and from averaged normals" loading="lazy" src="live.html#%s">
</iframe>
""" % "&amp;".join(("shape=sphere", "left=mip", "elevation=12", "distance=1.5", "exposure=-0.3", "x=-0.5", "y=-0.6",
                    "z=0.62"))
# A build replaces a folder only if the folder contains this file.
MARK = ".multum_site"
LIST_ITEM = re.compile(r"( *)([-*+]|\d{1,9}[.)])( +)(?=\S)")
TABLE_RULE = re.compile(r" *\|?[ :|-]*-{3,}[ :|-]*$")
# The theme's scripts use these addresses only for diagrams and repositories, neither of which this site has.
FOREIGN_ADDRESSES = re.compile(r"https://(?:unpkg\.com|api\.github\.com|\$\{e\}/api)[^\"'`]*")


class BuildFault(Exception):
    """The site cannot be built. The message states why."""


def site_path(name):
    """Returns the path in the site of a file of the project. Files outside docs/ are in files/."""
    if name == "README.md":
        return "index.md"
    if name.startswith("docs/"):
        return name.removeprefix("docs/")
    return f"files/{name}.txt"


class LinkRewriter:
    """Rewrites the links of a page for the site. `others` collects linked files that are outside docs/."""

    def __init__(self, root, name, others):
        self.root, self.name, self.others = root, name, others

    def target(self, target):
        path, mark, anchor = target.partition("#")
        if not path or re.match(r"[a-z][a-z+.-]*:", target):
            return target
        name = os.path.normpath(os.path.join(os.path.dirname(self.name), path))
        if not (self.root / name).is_file():
            return target
        if not name.startswith("docs/") and name != "README.md":
            self.others.add(name)
        here = os.path.dirname(site_path(self.name))
        return os.path.relpath(site_path(name), here or ".") + mark + anchor

    def text(self, text):
        """Rewrites all links outside of code spans."""
        parts, end = [], 0
        for span in CODE_SPAN.finditer(text):
            parts += [self.prose(text[end:span.start()]), span[0]]
            end = span.end()
        return "".join([*parts, self.prose(text[end:])])

    def prose(self, text):
        for pattern in (LINK, REFERENCE, ATTRIBUTE):
            text = pattern.sub(
                lambda found: found[0].replace(found[1], self.target(found[1])) if found[1] else found[0], text)
        return text


class ListIndents:
    """Maps the columns of nested lists to Python-Markdown's four spaces per level. `columns` has the column of the text
    of each open list; `is_loose` is true if the last item contains a blank line or code."""

    def __init__(self):
        self.columns = []
        self.is_loose = False

    def of(self, line, is_after_blank):
        """Returns the line with its new indent. Text without an indent ends a list only after a blank line."""
        item = LIST_ITEM.match(line)
        indent = len(line) - len(line.lstrip(" "))
        is_new = item is not None or is_after_blank or HEADING.match(line) or FENCE.match(line)
        if is_new:
            while self.columns and indent < self.columns[-1]:
                self.columns.pop()
        depth = len(self.columns)
        base = self.columns[-1] if self.columns else 0
        text = line[min(indent, base):]
        if item and (self.columns or indent < 4):
            self.columns.append(item.end())
            self.is_loose = False
            marker = item[2].replace(")", ".")
            return "    " * depth + f"{marker:<3} " + line[item.end():]
        return "    " * depth + text


def is_table_head(lines, at):
    return "|" in lines[at] and at + 1 < len(lines) and "|" in lines[at + 1] and TABLE_RULE.match(lines[at + 1])


def for_python_markdown(text):
    """Rewrites a page from GitHub's Markdown. Headings get the anchors that GitHub gives to them."""
    def change(part):
        return re.sub(r"<details( open)?>", r'<details markdown="1"\1>', COMMENT.sub("", part))
    lines = changed_outside_fences(text, change).split("\n")
    out, indents, fence, anchors = [], ListIndents(), "", Anchors()
    for at, line in enumerate(lines):
        found = FENCE.match(line)
        is_after_blank = not out or not out[-1].strip()
        if fence:
            column = indents.columns[-1] if indents.columns else 0
            kept = line[min(column, len(line) - len(line.lstrip(" "))):]
            out.append("    " * len(indents.columns) + kept if line.strip() else "")
            if found and found[2].startswith(fence) and not found[3]:
                fence = ""
            continue
        if not line.strip():
            out.append("")
            indents.is_loose = True
            continue
        begins_list = LIST_ITEM.match(line) and (not indents.columns or indents.is_loose)
        if not is_after_blank and (is_table_head(lines, at) or begins_list):
            out.append("")
        line = indents.of(line, is_after_blank)
        if found:
            fence, indents.is_loose = found[2], True
        heading = HEADING.match(line)
        if heading:
            line = f"{heading[1]} {heading[2]} {{ #{anchors.of(heading[2])} }}"
        elif line.lstrip().startswith("|"):
            line = CODE_SPAN.sub(lambda span: span[0].replace("\\|", "|"), line)
        out.append(line)
    return "\n".join(out)


def staged_pages(root, folder):
    """Writes the pages and all files to which they link into `folder`. Returns {path in the site: title}."""
    titles, others = {}, set()
    for name in page_names(root):
        path = folder / site_path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        links = LinkRewriter(root, name, others)
        path.write_text(for_python_markdown(changed_outside_fences((root / name).read_text(), links.text)))
        titles[site_path(name)] = Page(root, name).title()
    for file in sorted((root / "docs").rglob("*")):
        if file.is_file() and file.suffix != ".md":
            others.add(file.relative_to(root).as_posix())
    for name in others:
        path = folder / site_path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(root / name, path)
    return titles


def navigation(titles):
    """Returns the first page, then the six folders with their pages."""
    found = [{"Start": "index.md"}]
    for folder in FOLDERS:
        order = ORDER.get(folder, ())

        def place(path):
            stem = pathlib.PurePosixPath(path).stem
            return order.index(stem) if stem in order else len(order), titles[path].lower()
        pages = sorted((path for path in titles if folder_of(f"docs/{path}") == folder), key=place)
        if pages:
            found.append({TITLES[folder]: [{titles[path]: path} for path in pages]})
    return found


def configuration(source, output, titles):
    """Returns the configuration of mkdocs. Written as JSON, the configuration is also YAML."""
    def palette(scheme, icon, name):
        return {"media": f"(prefers-color-scheme: {'dark' if scheme == 'slate' else 'light'})", "scheme": scheme,
                "primary": "blue-grey", "accent": "teal", "toggle": {"icon": icon, "name": name}}
    return {
        "site_name": "multum", "site_description": "Normal maps that keep their look at a distance",
        "docs_dir": str(source), "site_dir": str(output), "use_directory_urls": False,
        "theme": {"name": "material", "custom_dir": str(HERE / "theme"), "font": False, "language": "en",
                  "features": ["navigation.tabs", "navigation.top", "search.highlight"],
                  "palette": [palette("default", "material/weather-night", "Use dark colours"),
                              palette("slate", "material/weather-sunny", "Use light colours")]},
        "extra": {"generator": False},
        "extra_css": ["assets/site.css"],
        "plugins": [{"search": {"lang": "en"}}],
        "markdown_extensions": ["attr_list", "md_in_html", "sane_lists", "tables", {"toc": {"permalink": True}},
                                {"pymdownx.highlight": {"pygments_lang_class": True}}, "pymdownx.superfences"],
        "nav": navigation(titles)}


def live_page(programs, page):
    """Writes the page of multum look with materials of `multum testmap`. Returns None, or why there is none."""
    if not (programs / "multum").is_file():
        return f"{programs} has no multum"
    words = []
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(temporary)
        for name, title, roughness, metalness in LIVE_MATERIALS:
            for command in (("testmap", "--material", name, work / name, "--size", LIVE_SIZE),
                            ("bake", work / f"{name}_normal.png", "-o", work / f"{name}.ndf.exr", "--green", "down",
                             "--no-measure")):
                if why := why_multum_fails(programs, *command):
                    return why
            words += [work / f"{name}.ndf.exr", "--source", work / f"{name}_normal.png", "--albedo",
                      work / f"{name}_albedo.png", "--title", title, "--base-roughness", roughness, "--metalness",
                      metalness]
        why = why_multum_fails(programs, "look", *words, "-o", page, "--no-open")
        return why or (None if page.is_file() else "multum look wrote no page")


def why_multum_fails(programs, *words):
    done = subprocess.run([str(one) for one in (programs / "multum", *words)], capture_output=True, text=True,
                          check=False)
    return f"multum {words[0]} failed: {done.stderr.strip()}" if done.returncode != 0 else None


def with_live_frame(text):
    """Puts the live page before the first section."""
    head, section, rest = text.partition("\n## ")
    return head + LIVE_FRAME + section + rest


def remove_foreign_addresses(output):
    """Removes addresses, languages and source maps of the theme that this site does not use. Also writes the index of
    the search as a script, because pages that are opened from a disk cannot load JSON."""
    scripts = output / "assets/javascripts"
    shutil.rmtree(scripts / "lunr", ignore_errors=True)
    for file in output.rglob("*.map"):
        file.unlink()
    for file in scripts.rglob("*.js"):
        text = re.sub(r"\n//# sourceMappingURL=.*", "", file.read_text())
        file.write_text(FOREIGN_ADDRESSES.sub("", text))
    for name in ("404.html", "sitemap.xml", "sitemap.xml.gz"):
        (output / name).unlink(missing_ok=True)
    index = (output / "search/search_index.json").read_text()
    # Newer versions of the theme load this file by themselves and expect this name.
    (output / "search/search_index.js").write_text(f"var __index = {index};\nmultumSearchIndex(__index);\n")


def build(root, output, programs):
    """Builds the site of the project in `root`. Replaces `output` if it is empty or an earlier site. If multum in
    the folder `programs` runs, the first page shows materials live. Returns None, or why it does not."""
    root, output = pathlib.Path(root).resolve(), pathlib.Path(output).resolve()
    program = shutil.which("mkdocs", path="/usr/bin:" + os.environ.get("PATH", ""))
    if program is None:
        raise BuildFault("mkdocs is missing; run tools/install_dependencies site")
    if output.exists() and (not output.is_dir() or (any(output.iterdir()) and not (output / MARK).is_file())):
        raise BuildFault(f"{output} has files that are not an earlier site; name another folder")
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(temporary)
        titles = staged_pages(root, work / "pages")
        why_not_live = live_page(programs, work / "live.html")
        if why_not_live is None:
            index = work / "pages/index.md"
            index.write_text(with_live_frame(index.read_text()))
        (work / "mkdocs.yml").write_text(json.dumps(configuration(work / "pages", work / "site", titles)))
        done = subprocess.run([program, "build", "--quiet", "-f", work / "mkdocs.yml"], capture_output=True, text=True,
                              check=False)
        if done.returncode != 0:
            raise BuildFault(f"mkdocs failed:\n{done.stdout}{done.stderr}")
        remove_foreign_addresses(work / "site")
        if why_not_live is None:
            shutil.copyfile(work / "live.html", work / "site/live.html")
        (work / "site" / MARK).write_text("tools/site replaces this folder.\n")
        if output.exists():
            shutil.rmtree(output)
        shutil.copytree(work / "site", output)
    return why_not_live
