"""Makes the site: does the tutorials that have changed, for their pictures, and calls Sphinx."""
import argparse
import sys
from pathlib import Path

from mesh_tools_test.site.assembly import SiteError, assemble, build, tutorials
from mesh_tools_test.site.diagrams import DiagramError
from mesh_tools_test.tutorials.tutorial import TutorialError
from mesh_tools_test.tutorials.tutorial_run import run_tutorial


def has_run(tutorial, pictures):
    """Whether the pictures of a page are there, and not older than the page."""
    done = pictures / (tutorial.path.name + ".done")
    return done.is_file() and done.stat().st_mtime >= tutorial.path.stat().st_mtime


def take_pictures(pictures, again):
    """Do the tutorials that have to be done."""
    for name, tutorial in tutorials().items():
        if again or not has_run(tutorial, pictures):
            print("tutorial %s" % name, flush=True)
            run_tutorial(tutorial, pictures)
            (pictures / (name + ".done")).touch()


def main():
    """The exit code is 1 where a tutorial or the site fails."""
    parser = argparse.ArgumentParser(prog="./run docs", description=__doc__)
    parser.add_argument("--again", action="store_true", help="do all tutorials once more")
    parser.add_argument("--no-run", action="store_true", help="grey pictures, where there are none")
    parser.add_argument("--output", type=Path, required=True, help="folder; html/ is made in it")
    options = parser.parse_args()
    pictures, html = options.output / "pictures", options.output / "html"
    try:
        if not options.no_run:
            take_pictures(pictures, options.again)
        assemble(options.output / "source", pictures)
        build(options.output / "source", html)
    except (DiagramError, SiteError, TutorialError) as error:
        print("docs: error: %s" % error, file=sys.stderr)
        return 1
    print("%s/index.html" % html)
    return 0


if __name__ == "__main__":
    sys.exit(main())
