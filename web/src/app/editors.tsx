// The forms of documents: a part of the page of their own.
export { ExerciseEditorPage } from "../features/exercises/exercise_editor";
export { RubricEditorPage } from "../features/exercises/rubric_editor";
export { ProfileEditorPage } from "../features/profiles/profile_editor";
