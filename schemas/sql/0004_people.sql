-- Schema 4: people, cohorts and stations are edited (each edit counts their revision), passwords for
-- one use, sessions that can be listed and ended, enrolment codes that can be listed and withdrawn,
-- every version of a device profile with its reports and calibrations; audit rows are never changed.

ALTER TABLE people ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;
-- 1: the password was made up by the server and is good for changing it, for nothing else.
ALTER TABLE people ADD COLUMN must_change_password INTEGER NOT NULL DEFAULT 0
  CHECK (must_change_password IN (0, 1));
CREATE INDEX people_by_role ON people (tenant, role, login);

-- Sessions get a name that opens nothing, and say when the password was given last.
CREATE TABLE sessions_4 (
  tenant       INTEGER NOT NULL,
  token_hash   BLOB NOT NULL CHECK (length(token_hash) = 32),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  person       BLOB NOT NULL,
  created_ms   INTEGER NOT NULL,
  last_used_ms INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  confirmed_ms INTEGER NOT NULL,
  via          TEXT NOT NULL,
  PRIMARY KEY (tenant, token_hash),
  UNIQUE (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
INSERT INTO sessions_4 (tenant, token_hash, id, person, created_ms, last_used_ms, expires_ms, confirmed_ms, via)
  SELECT tenant, token_hash, randomblob(16), person, created_ms, last_used_ms, expires_ms, created_ms, via FROM sessions;
DROP TABLE sessions;
ALTER TABLE sessions_4 RENAME TO sessions;
CREATE INDEX sessions_by_person ON sessions (tenant, person);

ALTER TABLE cohorts ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;
ALTER TABLE cohorts ADD COLUMN archived_ms INTEGER NOT NULL DEFAULT 0;  -- 0: in use

ALTER TABLE stations ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;
ALTER TABLE stations ADD COLUMN revoked_ms INTEGER NOT NULL DEFAULT 0;
-- As it said itself when it connected last.
ALTER TABLE stations ADD COLUMN software TEXT NOT NULL DEFAULT '';
ALTER TABLE stations ADD COLUMN core_version INTEGER NOT NULL DEFAULT 0;

CREATE TABLE enrol_codes_4 (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  code_hash    BLOB NOT NULL CHECK (length(code_hash) = 32),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  created_ms   INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  used_ms      INTEGER,
  withdrawn_ms INTEGER,
  PRIMARY KEY (tenant, code_hash),
  UNIQUE (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO enrol_codes_4 (tenant, code_hash, id, created_ms, expires_ms, used_ms)
  SELECT tenant, code_hash, randomblob(16), 0, expires_ms, used_ms FROM enrol_codes;
DROP TABLE enrol_codes;
ALTER TABLE enrol_codes_4 RENAME TO enrol_codes;

-- Every content a profile had; the newest version is the one in `profiles`.
CREATE TABLE profile_versions (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  version    INTEGER NOT NULL CHECK (version >= 1),
  title      TEXT NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  created_ms INTEGER NOT NULL,                       -- 0: before schema 4
  PRIMARY KEY (tenant, name, version)
) STRICT, WITHOUT ROWID;
INSERT INTO profile_versions (tenant, name, version, title, content, created_ms)
  SELECT tenant, name, 1, title, content, 0 FROM profiles;

-- What `enamel-station qualify` wrote about one content.
CREATE TABLE profile_reports (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  name       TEXT NOT NULL,
  version    INTEGER NOT NULL,
  media_type TEXT NOT NULL CHECK (media_type IN ('application/json', 'text/html')),
  content    BLOB NOT NULL CHECK (length(content) = 32),
  bytes      INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version, content),
  FOREIGN KEY (tenant, name, version) REFERENCES profile_versions (tenant, name, version)
) STRICT, WITHOUT ROWID;

-- Devices as they were measured (schemas/calibration.schema.json).
CREATE TABLE calibrations (
  tenant      INTEGER NOT NULL,
  id          BLOB NOT NULL CHECK (length(id) = 16),
  profile     TEXT NOT NULL,
  device      TEXT NOT NULL,
  measured_ms INTEGER NOT NULL,
  added_ms    INTEGER NOT NULL,
  document    TEXT NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, profile, document),
  FOREIGN KEY (tenant, profile) REFERENCES profiles (tenant, name)
) STRICT, WITHOUT ROWID;
CREATE INDEX calibrations_by_profile ON calibrations (tenant, profile, measured_ms);

CREATE INDEX audit_by_object ON audit (tenant, object, id);
CREATE INDEX audit_by_actor ON audit (tenant, actor, id);

-- The audit trail is append-only. One thing is allowed, because erasing a person asks for it
-- (schemas/personal_data.md): once the person is no longer there, what rows about that person tell is
-- overwritten with '{"erased":true}'; who did what and when stays.
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never deleted');
END;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND
  NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND
  OLD.action LIKE 'person.%' AND
  NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
              lower(hex(p.id)) = replace(OLD.object, '-', '')))
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;
