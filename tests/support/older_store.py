"""A data folder's store as a daemon of an older version left it."""

import os
import pathlib
import re
import sqlite3

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))


def migrations():
    """The steps of server/store/schema.h."""
    return re.findall(r'R"sql\((.*?)\)sql"', (SOURCE / "server" / "store" / "schema.h").read_text(), re.DOTALL)


def make_older(store, version, changes=()):
    """Replaces the store, which nobody has open, by one that the steps up to `version` make, with the rows of now in it;
    `changes` are SQL statements for what rows of that time did not have."""
    older = store.with_suffix(".older")
    made = sqlite3.connect(older, isolation_level=None)
    made.executescript("BEGIN;" + "".join(migrations()[:version]) + f"PRAGMA user_version = {version}; COMMIT")
    made.execute("ATTACH ? AS now", (str(store),))
    made.execute("PRAGMA foreign_keys = OFF")
    made.execute("BEGIN")
    tables = [name for (name,) in made.execute("SELECT name FROM main.sqlite_schema WHERE type = 'table'")]
    for table in tables:
        columns = ", ".join(name for (name,) in made.execute("SELECT name FROM pragma_table_info(?)", (table,)))
        made.execute(f"DELETE FROM main.{table}")
        made.execute(f"INSERT OR REPLACE INTO main.{table} ({columns}) SELECT {columns} FROM now.{table}")
    for change in changes:
        made.execute(change)
    made.execute("COMMIT")
    made.close()
    for suffix in ("-wal", "-shm"):
        store.with_name(store.name + suffix).unlink(missing_ok=True)
    older.rename(store)


def rows_of(store, version):
    """{table: rows} of the columns that a store of that version has, sorted."""
    empty = sqlite3.connect(":memory:")
    empty.executescript("".join(migrations()[:version]))
    found = sqlite3.connect(store)
    rows = {}
    for (table,) in empty.execute("SELECT name FROM sqlite_schema WHERE type = 'table'"):
        columns = ", ".join(name for (name,) in empty.execute("SELECT name FROM pragma_table_info(?)", (table,)))
        rows[table] = sorted(map(repr, found.execute(f"SELECT {columns} FROM {table}")))
    found.close()
    return rows


def version_of(store):
    found = sqlite3.connect(store)
    (version,) = found.execute("PRAGMA user_version").fetchone()
    found.close()
    return version
