-- Schema 11: exercises have owners.

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
