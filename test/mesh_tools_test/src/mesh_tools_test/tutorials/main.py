"""Does tutorials as readers would, and keeps the pictures that they make."""
import argparse
import sys
from pathlib import Path

from mesh_tools_test.tutorials.tutorial import TutorialError, read_tutorial
from mesh_tools_test.tutorials.tutorial_run import run_tutorial


def main():
    """Run pages in their order; the exit code is 1 if one fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", nargs="+", type=Path, help="Markdown files")
    parser.add_argument("--pictures", type=Path, required=True, help="folder for their pictures")
    parser.add_argument("--work", type=Path, help="folder to work in, which stays (one page only)")
    options = parser.parse_args()
    if options.work and len(options.pages) > 1:
        parser.error("--work is for one page")
    failed = False
    for page in options.pages:
        print(page.name, flush=True)
        try:
            run_tutorial(
                read_tutorial(page),
                options.pictures,
                options.work,
                lambda line: print(line, flush=True),
            )
        except TutorialError as error:
            print("%s: %s" % (page, error), file=sys.stderr)
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
