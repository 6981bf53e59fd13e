"""`python -m fric`."""

from fric.cli.main import main

main()
