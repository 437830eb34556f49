-- Schema 12: rows of the audit trail are signed, and tell the whole state of what they decided (schemas/audit.md).

-- What the row decided about, "assignment <id>"; '': nothing that a row of its own keeps.
ALTER TABLE audit ADD COLUMN subject TEXT NOT NULL DEFAULT '';
-- Its columns after that, a JSON object of texts; '': there is no subject, or it is gone.
ALTER TABLE audit ADD COLUMN state TEXT NOT NULL DEFAULT '';
-- Random; NULL: the row was erased, or is from before this schema.
ALTER TABLE audit ADD COLUMN salt BLOB CHECK (length(salt) = 32);
-- Of salt, before, after and state: what the signature covers in their place, so that it holds when they are erased.
ALTER TABLE audit ADD COLUMN content_hash BLOB CHECK (length(content_hash) = 32);
-- Ed25519, with the server's ticket key; NULL: from before this schema.
ALTER TABLE audit ADD COLUMN signature BLOB CHECK (length(signature) = 64);
CREATE INDEX audit_by_subject ON audit (tenant, subject, id) WHERE subject <> '';

-- A row: there is a trail from before this schema, and nothing that was decided in it is signed yet. The start that signs
-- it takes the row away.
CREATE TABLE audit_to_begin (
  tenant INTEGER NOT NULL PRIMARY KEY
) STRICT;
INSERT INTO audit_to_begin (tenant) SELECT DISTINCT tenant FROM audit;

-- As schema 7, and what is erased takes its state and salt along.
DROP TRIGGER audit_is_not_changed;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND NEW.subject = OLD.subject AND
  NEW.content_hash IS OLD.content_hash AND NEW.signature IS OLD.signature AND NEW.salt IS NULL AND
  NEW.state = CASE OLD.state WHEN '' THEN '' ELSE '{"erased":true}' END AND
  NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
    ((OLD.action LIKE 'person.%' OR OLD.action LIKE 'session.%' OR OLD.action = 'request.refused') AND
     NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
                 lower(hex(p.id)) = replace(OLD.object, '-', ''))) OR
    (OLD.action <> 'attempt.ticket' AND
     EXISTS (SELECT 1 FROM audit t WHERE t.tenant = OLD.tenant AND t.object = OLD.object AND
             t.action = 'attempt.ticket' AND
             replace(json_extract(t.after_json, '$.person'), '-', '') NOT IN
               (SELECT lower(hex(p.id)) FROM people p WHERE p.tenant = OLD.tenant)))))
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;
