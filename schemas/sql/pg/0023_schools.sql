-- Schema 23: other schools of one installation, and marks of a move.

-- Each has a data folder of its own below this one's, a database or a schema of its own, and host names that its page is
-- opened under (server/storage/school_store.h). Empty where a server is one school's.
CREATE TABLE schools (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  name       TEXT COLLATE "C" NOT NULL,
  id         BYTEA NOT NULL CHECK (length(id) = 16),
  hosts      TEXT COLLATE "C" NOT NULL,  -- lower case, without port, one space between two
  state      TEXT COLLATE "C" NOT NULL CHECK (state IN ('being_made', 'served', 'suspended', 'being_deleted')),
  created_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name)
);

-- That the school was moved out of this database, or is being moved into it and is half here
-- (server/storage/engine/move_rows.h): for servers whose folders have no mark of the move.
CREATE TABLE move_marks (
  tenant BIGINT NOT NULL REFERENCES tenants (tenant),
  mark   TEXT COLLATE "C" NOT NULL CHECK (mark IN ('moved', 'moving')),
  PRIMARY KEY (tenant, mark)
);
