-- Schema 22: how far remarks to chairs have come, and which stations are connected to which server.

-- Of a remark to the chair (to_chair = 1): what its station knows it by, which grows with each of an attempt's,
-- and how far it has come. NULL of what was said before this schema.
ALTER TABLE annotations ADD COLUMN remark_id INTEGER CHECK (remark_id > 0);
ALTER TABLE annotations ADD COLUMN remark_state TEXT CHECK (remark_state IN ('waiting', 'sent', 'shown'));
ALTER TABLE annotations ADD COLUMN shown_ms INTEGER NOT NULL DEFAULT 0;
CREATE INDEX annotations_to_chairs ON annotations (tenant, created_ms) WHERE remark_id IS NOT NULL;

-- Servers that are running, each under a name of its own for as long as it runs, and the stations that are connected to
-- them. One that has not been heard for a while is gone (server/storage/live_store.h). Empty where only one server can
-- have its rows here.
CREATE TABLE running_servers (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  server   BLOB NOT NULL CHECK (length(server) = 16),
  heard_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, server)
) STRICT, WITHOUT ROWID;
CREATE TABLE station_links (
  tenant        INTEGER NOT NULL REFERENCES tenants (tenant),
  server        BLOB NOT NULL CHECK (length(server) = 16),
  station       BLOB NOT NULL CHECK (length(station) = 16),
  shows_remarks INTEGER NOT NULL CHECK (shows_remarks IN (0, 1)),
  PRIMARY KEY (tenant, server, station)
) STRICT, WITHOUT ROWID;
