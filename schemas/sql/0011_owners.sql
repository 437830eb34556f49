-- Schema 11: exercises have owners, an assignment stays with the version of its exercise, and says
-- what counts of several attempts.

-- Who may publish versions of an exercise, correct its rubric, retire and share it: the owner, and admins. By name, because
-- all versions of a name are one exercise.
CREATE TABLE exercise_owners (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  name   TEXT NOT NULL,
  owner  BLOB,                                            -- a person; NULL: the school's, hence the admins'
  shared INTEGER NOT NULL CHECK (shared IN (0, 1)),       -- other instructors may read and assign it
  PRIMARY KEY (tenant, name),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;
-- Nobody said until now who had made one, and everybody could use all.
INSERT INTO exercise_owners (tenant, name, owner, shared) SELECT DISTINCT tenant, name, NULL, 1 FROM exercises;

-- The version that is to be done, until somebody moves the assignment to another. Until now it was the newest.
ALTER TABLE assignments ADD COLUMN exercise BLOB CHECK (length(exercise) = 16);
UPDATE assignments SET exercise = (SELECT e.id FROM exercises e WHERE e.tenant = assignments.tenant AND
  e.name = assignments.exercise_name AND e.version > 0 ORDER BY e.state = 3, e.version DESC LIMIT 1);

-- A person's result under the assignment: of the attempts that are scored.
ALTER TABLE assignments ADD COLUMN counting TEXT NOT NULL DEFAULT 'best'
  CHECK (counting IN ('best', 'last', 'mean', 'median'));
