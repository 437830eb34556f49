import { type Json, withValue } from "../../base/document";

const kMaxName = 64; // as schemas/exercise.schema.json

// A name for a title: what schemas/exercise.schema.json allows of it, in small letters. Empty where nothing is left, as
// of a Chinese title.
export function nameFor(title: string): string {
  return title
    .normalize("NFD")
    .toLowerCase()
    .replaceAll("ß", "ss")
    .replace(/\p{Mark}/gu, "")
    .replace(/[^a-z0-9]+/g, "-")
    .slice(0, kMaxName)
    .replace(/^-|-$/g, "");
}

export const isName = (name: string): boolean => /^[a-z0-9_-]{1,64}$/.test(name);

// The same exercise under another name.
export function copied(document: Json, name: string, title: string): Json {
  return withValue(withValue(document, ["name"], name), ["title"], title);
}
