"""`python -m fric`."""

from fric.cli.main import main

if __name__ == "__main__":  # not where a worker process imports it
    main()
