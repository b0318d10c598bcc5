"""The command line of the library, ``jawenv``, and how all commands of the project are run."""
