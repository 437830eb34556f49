-- Schema 23: other schools of one installation, and marks of a move.

-- Each has a data folder of its own below this one's, a database or a schema of its own, and host names that its page is
-- opened under (server/storage/school_store.h). Empty where a server is one school's.
CREATE TABLE schools (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  hosts      TEXT NOT NULL,  -- lower case, without port, one space between two
  state      TEXT NOT NULL CHECK (state IN ('being_made', 'served', 'suspended', 'being_deleted')),
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

-- That the school was moved out of this database, or is being moved into it and is half here
-- (server/storage/engine/move_rows.h): for servers whose folders have no mark of the move.
CREATE TABLE move_marks (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  mark   TEXT NOT NULL CHECK (mark IN ('moved', 'moving')),
  PRIMARY KEY (tenant, mark)
) STRICT, WITHOUT ROWID;
