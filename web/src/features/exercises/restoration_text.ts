import { nameOf } from "../../api/builtin_words";
import type { Exercise } from "../../api/types";
import { sayIf } from "../../base/words";

const kTellingWords = 3;

type Restoration = NonNullable<Exercise["rubric"]["restoration"]>;

// Where a material's figures come from: the server's sentence, which is English, or a school's own. The material and the
// last words tell the built-in ones apart.
export function sourceText({ name, source }: Restoration): string {
  const end = nameOf(source).split("_").slice(-kTellingWords).join("_");
  return sayIf(`restoration_source.${name}_${end}`) ?? source;
}
