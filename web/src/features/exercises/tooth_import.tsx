import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { mesialX } from "../../api/tooth_number";
import { say } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { CheckField, SelectField, TextField } from "../../widgets/form";
import { BuiltinTooth } from "./builtin_tooth";
import { drawn, type GumCurves, JawCut, kLeastPoints, kNoCurves } from "./jaw_cut";
import { Findings, useMeshUpload } from "./mesh_upload";
import { type Shown, ToothUpright, uprightOf } from "./tooth_upright";
import { directionText, type Upright } from "./upright";

// ISO 3950, quadrant by quadrant: permanent teeth, then deciduous ones.
const kTeeth = [1, 2, 3, 4, 5, 6, 7, 8].flatMap((quadrant) =>
  [1, 2, 3, 4, 5, 6, 7, 8].slice(0, quadrant <= 4 ? 8 : 5).map((tooth) => `${quadrant}${tooth}`),
);

interface Props {
  readonly client: Client;
  readonly admin: boolean; // for built-in teeth
  readonly onDone: () => void; // a tooth is there
  readonly onClose: () => void;
}

// A built-in tooth, or a mesh of the person's, with its exercises. Where the mesh holds several teeth, the person cuts one
// out. Then the dialog shows what a mesh becomes, and publishes it as it was turned.
export function AddTooth({ client, admin, onDone, onClose }: Props) {
  const mesh = useMeshUpload(client);
  const [title, setTitle] = useState("");
  const [tooth, setTooth] = useState("");
  const [practice, setPractice] = useState(false);
  const [shown, setShown] = useState<Shown>();
  const [upright, setUpright] = useState<Upright>();
  const [agreed, setAgreed] = useState(false);
  const [several, setSeveral] = useState(false); // teeth in the file
  const [jaw, setJaw] = useState<string>(); // the import that showed them
  const [curves, setCurves] = useState(kNoCurves);
  const { file, now, busy, problems } = mesh;

  const wanted = { title: title.trim(), tooth: Number(tooth) };
  const showJaw = async () => {
    const done = await mesh.send({ ...wanted, jaw: true, publish: false });
    if (done?.state !== "done") return;
    setJaw(done.id);
    setCurves(kNoCurves);
  };
  const send = async (publish: boolean, as: Upright | undefined) => {
    const done = await mesh.send({
      ...wanted,
      ...(jaw === undefined ? {} : { around: drawn(curves) }),
      ...(as === undefined ? {} : { up: directionText(as.up), buccal: directionText(as.buccal) }),
      publish,
      practice,
    });
    if (done?.state !== "done") return;
    if (done.tooth !== null) onDone();
    else if (done.stance !== null) {
      const found = uprightOf(done.stance);
      setShown({ id: done.id, stance: done.stance, found, findings: done.findings });
      setUpright(found);
      setAgreed(false);
    }
  };

  if (now?.state === "done" && now.tooth !== null) {
    return (
      <>
        <Notice tone="good" title={now.tooth.title}>
          <p>{say("tooth_import.published", { count: now.tooth.exercises.length })}</p>
        </Notice>
        <Findings lines={now.findings} />
        <div class="button-row">
          <button type="button" class="button primary" onClick={onClose}>
            {say("common.close")}
          </button>
        </div>
      </>
    );
  }
  const preview = () => {
    if (shown === undefined || upright === undefined) return null;
    const { stance, found } = shown;
    const unsure = upright === found && (stance.up_is === "guess" || !stance.buccal_given);
    return (
      <form
        class="form"
        onSubmit={(event) => {
          event.preventDefault();
          void send(true, upright);
        }}
      >
        <ToothUpright
          client={client}
          shown={shown}
          title={title}
          busy={busy}
          mesial={mesialX(Number(tooth))}
          upright={upright}
          onTurn={setUpright}
          onAgain={() => void send(false, upright)}
        />
        <Findings lines={shown.findings} />
        <CheckField
          label={say("tooth_import.practice")}
          value={practice}
          onValue={setPractice}
          hint={say("tooth_import.practice_hint")}
        />
        {unsure && <CheckField label={say("tooth_import.agree")} value={agreed} onValue={setAgreed} />}
        {problems}
        <div class="button-row">
          <button type="button" class="button" disabled={busy} onClick={() => setShown(undefined)}>
            {jaw === undefined ? say("tooth_import.back") : say("jaw_cut.back")}
          </button>
          <Button busy={busy} blocked={unsure && !agreed ? say("tooth_import.agree_first") : undefined}>
            {say("tooth_import.publish")}
          </Button>
        </div>
      </form>
    );
  };
  const form = () => (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        void (several ? showJaw() : send(false, undefined));
      }}
    >
      {mesh.fields(say("tooth_import.mesh"))}
      <CheckField
        label={say("jaw_cut.several")}
        value={several}
        onValue={setSeveral}
        hint={say("jaw_cut.several_hint")}
      />
      <TextField
        label={say("account.name")}
        value={title}
        onValue={setTitle}
        required
        maxLength={200}
        hint={say("tooth_import.name_hint")}
      />
      <SelectField
        label={say("tooth_import.tooth")}
        value={tooth}
        onValue={setTooth}
        options={[
          { value: "", title: say("tooth_import.choose") },
          ...kTeeth.map((number) => ({ value: number, title: number })),
        ]}
        hint={say("tooth_import.tooth_hint")}
      />
      {jaw === undefined && problems}
      <div class="button-row">
        <button type="button" class="button" onClick={onClose}>
          {say("common.cancel")}
        </button>
        <Button
          busy={busy}
          blocked={needed({
            [say("tooth_import.mesh")]: file,
            [say("account.name")]: title.trim(),
            [say("tooth_import.tooth")]: tooth,
          })}
        >
          {say(several ? "jaw_cut.show" : "tooth_import.show")}
        </Button>
      </div>
    </form>
  );
  const cut = (id: string) => (
    <form
      class="form"
      style={{ display: shown === undefined ? "" : "none" }}
      onSubmit={(event) => {
        event.preventDefault();
        void send(false, undefined);
      }}
    >
      <JawCut client={client} id={id} title={title} curves={curves} onCurves={setCurves} />
      {shown === undefined && problems}
      <div class="button-row">
        <button type="button" class="button" disabled={busy} onClick={() => setJaw(undefined)}>
          {say("tooth_import.back")}
        </button>
        <Button busy={busy} blocked={missing(curves)}>
          {say("tooth_import.show")}
        </Button>
      </div>
    </form>
  );
  // The browser keeps the file that was chosen only while its field is there.
  return (
    <>
      {preview()}
      {jaw !== undefined && cut(jaw)}
      <div class="form" style={{ display: shown === undefined && jaw === undefined ? "" : "none" }}>
        {admin && <BuiltinTooth client={client} onDone={onDone} />}
        <h3>{say("tooth_import.own")}</h3>
        {form()}
      </div>
    </>
  );
}

// Why no tooth can be cut out yet.
function missing(curves: GumCurves): string | undefined {
  const few = curves.findIndex(({ length }, i) => length < kLeastPoints && (i === 0 || length > 0));
  return few < 0 ? undefined : say("jaw_cut.few", { least: kLeastPoints });
}
