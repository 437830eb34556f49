import { type Json, type Path, valueAt } from "../../base/document";
import { say } from "../../base/words";
import { Brief } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import {
  type DocumentForm,
  DocumentChoice,
  DocumentNumber,
  DocumentText,
  problemAt,
} from "../../widgets/document_fields";
import { shapeOptions } from "./editor_text";
import { freshBur, kMaxOthers } from "./other_burs";

const kMm = 1000;
const kOthers: Path = ["other_burs"];

// One bur of the document.
export function BurFields({ form, path }: { readonly form: DocumentForm; readonly path: Path }) {
  const at = (member: string) => ({ form, path: [...path, member] });
  const ball = valueAt(form.edit.now, [...path, "shape"]) === "sphere";
  return (
    <div class="form-grid">
      <DocumentChoice {...at("shape")} label={say("editor.shape")} options={shapeOptions()} />
      <DocumentNumber {...at("radius_um")} label={say("editor.radius")} scale={kMm} />
      <DocumentNumber
        {...at("length_um")}
        label={say("editor.length")}
        hint={ball ? say("editor.zero_ball") : say("editor.least_length")}
        scale={kMm}
      />
      <DocumentNumber
        {...at("narrow_radius_um")}
        label={say("editor.narrow")}
        hint={say("editor.narrow_hint")}
        scale={kMm}
        optional
      />
      <DocumentNumber
        {...at("shank_radius_um")}
        label={say("editor.shank")}
        hint={say("editor.no_shank")}
        scale={kMm}
        optional
      />
      <DocumentNumber {...at("neck_um")} label={say("editor.neck")} scale={kMm} optional />
      <DocumentText
        {...at("iso_number")}
        label={say("editor.iso_number")}
        hint={say("editor.iso_hint")}
        maxLength={64}
        optional
      />
    </div>
  );
}

// What the bur may be changed for during the attempt.
export function OtherBurs({ form }: { readonly form: DocumentForm }) {
  const now = form.edit.at(kOthers);
  const others: readonly Json[] = Array.isArray(now) ? now : [];
  // A list that is there has one bur at least.
  const set = (list: readonly Json[]) => form.edit.set(kOthers, list.length === 0 ? undefined : list);
  const problem = problemAt(form, kOthers);
  return (
    <>
      <p class="hint">{say("editor.other_burs")}</p>
      {others.map((_bur, i) => (
        <fieldset class="group" key={i}>
          <legend>{say("editor.other_bur", { number: String(i + 2) })}</legend>
          <BurFields form={form} path={[...kOthers, i]} />
          <div>
            <button type="button" class="button small" onClick={() => set(others.filter((_other, at) => at !== i))}>
              <Brief shown={say("common.remove")} full={say("editor.remove_bur", { number: String(i + 2) })} />
            </button>
          </div>
        </fieldset>
      ))}
      {problem !== undefined && <p class="field-problem">{problem}</p>}
      <div>
        <Button
          kind="small"
          blocked={others.length < kMaxOthers ? undefined : say("editor.most_burs", { count: String(kMaxOthers + 1) })}
          onClick={() => set([...others, freshBur([form.edit.at(["bur"]) ?? null, ...others])])}
        >
          {say("editor.add_bur")}
        </Button>
      </div>
    </>
  );
}
