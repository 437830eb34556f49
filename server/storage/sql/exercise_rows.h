#pragma once

// Exercises with who owns them, for statements that read ExerciseRow (ExerciseOf in sqlite_impl.h):
//   "SELECT " ENAMEL_EXERCISE_COLUMNS " FROM exercises e " ENAMEL_EXERCISE_OWNERS " WHERE …"
#define ENAMEL_EXERCISE_COLUMNS                                                               \
  "e.id, e.name, e.version, e.title, e.content, e.scene, e.graded, e.published_ms, e.state, " \
  "e.revision, o.owner, coalesce(w.display_name, ''), coalesce(o.shared, 1)"
#define ENAMEL_EXERCISE_OWNERS                                              \
  "LEFT JOIN exercise_owners o ON o.tenant = e.tenant AND o.name = e.name " \
  "LEFT JOIN people w ON w.tenant = o.tenant AND w.id = o.owner "
