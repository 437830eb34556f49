import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { placedMessage } from "../../api/placed";
import { mesialX } from "../../api/tooth_number";
import type { ToothImport, ToothWanted } from "../../api/types";
import { say } from "../../base/words";
import { ErrorNotice, Notice, Progress } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { CheckField, FileField, NumberField, SelectField, TextField } from "../../widgets/form";
import { BuiltinTooth } from "./builtin_tooth";
import { type Shown, ToothUpright, uprightOf } from "./tooth_upright";
import { directionText, type Upright } from "./upright";

const kPollMs = 700;
const kPartBytes = 512 * 1024; // of a mesh, in one request: the server takes 1 MiB
const kUnits = ["mm", "um", "cm", "m", "inch"] as const;
type Scale = (typeof kUnits)[number] | "factor" | "longest";
// ISO 3950, quadrant by quadrant: permanent teeth, then deciduous ones.
const kTeeth = [1, 2, 3, 4, 5, 6, 7, 8].flatMap((quadrant) =>
  [1, 2, 3, 4, 5, 6, 7, 8].slice(0, quadrant <= 4 ? 8 : 5).map((tooth) => `${quadrant}${tooth}`),
);

// Sends a mesh in parts and asks until it is done or refused; `onChange` hears of each step. If the person leaves
// before all of it was sent, the server forgets the upload.
async function importTooth(
  client: Client,
  file: File,
  about: ToothWanted,
  onChange: (now: ToothImport) => void,
  signal: AbortSignal,
): Promise<ApiResult<ToothImport>> {
  let now: ApiResult<ToothImport> = await client.post("/tooth-imports", {
    body: { file_name: file.name, bytes: file.size, ...about },
  });
  while (now.ok) {
    const { id, state, received: offset } = now.value;
    if (signal.aborted) {
      if (state === "receiving") await client.delete("/tooth-imports/{id}", { id });
      return now;
    }
    onChange(now.value);
    if (state === "done" || state === "refused") return now;
    if (state === "receiving") {
      const body = file.slice(offset, offset + kPartBytes);
      now = await client.put("/tooth-imports/{id}/bytes", { id, offset, body, type: "application/octet-stream" });
    } else {
      await new Promise((done) => setTimeout(done, kPollMs));
      now = await client.get("/tooth-imports/{id}", { id });
    }
  }
  return now;
}

interface Props {
  readonly client: Client;
  readonly onDone: () => void; // a tooth is there
  readonly onClose: () => void;
}

// A built-in tooth, or a mesh of the admin's, with its exercises. First shows what a mesh becomes, then publishes it as
// it was turned.
export function AddTooth({ client, onDone, onClose }: Props) {
  const [file, setFile] = useState<File>();
  const [title, setTitle] = useState("");
  const [scale, setScale] = useState<Scale>("mm");
  const [factor, setFactor] = useState(1);
  const [longest, setLongest] = useState(10);
  const [tooth, setTooth] = useState("");
  const [practice, setPractice] = useState(false);
  const [now, setNow] = useState<ToothImport>();
  const [shown, setShown] = useState<Shown>();
  const [upright, setUpright] = useState<Upright>();
  const [agreed, setAgreed] = useState(false);
  const [refused, setRefused] = useState<string>();
  const leaving = useRef(new AbortController());
  useEffect(() => () => leaving.current.abort(), []);
  const busy = now !== undefined && (now.state === "receiving" || now.state === "working");

  const send = async (publish: boolean, as: Upright | undefined) => {
    if (file === undefined || busy) return;
    setRefused(undefined);
    const sent = await importTooth(
      client,
      file,
      {
        title: title.trim(),
        tooth: Number(tooth),
        unit: scale === "factor" || scale === "longest" ? "mm" : scale,
        ...(scale === "factor" ? { scale: factor } : {}),
        ...(scale === "longest" ? { longest_mm: longest } : {}),
        ...(as === undefined ? {} : { up: directionText(as.up), buccal: directionText(as.buccal) }),
        publish,
        practice,
      },
      setNow,
      leaving.current.signal,
    );
    if (leaving.current.signal.aborted) return;
    if (!sent.ok) {
      setNow(undefined);
      setRefused(placedMessage(sent.error));
      return;
    }
    setNow(sent.value);
    const { state, tooth: published, stance } = sent.value;
    if (state !== "done") return;
    if (published !== null) onDone();
    else if (stance !== null) {
      const found = uprightOf(stance);
      setShown({ id: sent.value.id, stance, found, findings: sent.value.findings });
      setUpright(found);
      setAgreed(false);
    }
  };

  const problems = (
    <>
      {refused !== undefined && <ErrorNotice title={say("tooth_import.refused")} message={refused} />}
      {now?.state === "refused" && now.problem !== null && (
        <ErrorNotice title={say("tooth_import.impossible")} message={now.problem.message} />
      )}
      <div aria-live="polite">{busy && <Work now={now} />}</div>
    </>
  );
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
            {say("tooth_import.back")}
          </button>
          <Button busy={busy} blocked={unsure && !agreed ? say("tooth_import.agree_first") : undefined}>
            {say("tooth_import.publish")}
          </Button>
        </div>
      </form>
    );
  };
  const mesh = () => (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        void send(false, undefined);
      }}
    >
      <FileField
        label={say("tooth_import.mesh")}
        accept=".stl,.ply,.obj,.off"
        onFile={setFile}
        hint={say("tooth_import.mesh_hint")}
      />
      <SelectField
        label={say("tooth_import.unit")}
        value={scale}
        onValue={setScale}
        options={[
          ...kUnits.map((unit) => ({ value: unit, title: say(`length_unit.${unit}`) })),
          { value: "factor", title: say("tooth_import.factor") },
          { value: "longest", title: say("tooth_import.longest") },
        ]}
      />
      {scale === "factor" && (
        <NumberField label={say("tooth_import.factor_mm")} value={factor} onValue={setFactor} step="any" />
      )}
      {scale === "longest" && (
        <NumberField
          label={say("tooth_import.longest_mm")}
          value={longest}
          onValue={setLongest}
          min={3}
          max={40}
          step="any"
          hint={say("tooth_import.longest_hint")}
        />
      )}
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
      {problems}
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
          {say("tooth_import.show")}
        </Button>
      </div>
    </form>
  );
  // The browser keeps the file that was chosen only while its field is there.
  return (
    <>
      {preview()}
      <div class="form" style={{ display: shown === undefined ? "" : "none" }}>
        <BuiltinTooth client={client} onDone={onDone} />
        <h3>{say("tooth_import.own")}</h3>
        {mesh()}
      </div>
    </>
  );
}

function Findings({ lines }: { readonly lines: readonly string[] }) {
  return (
    <>
      <h3>{say("tooth_import.found")}</h3>
      <ul>
        {lines.map((line) => (
          <li key={line}>{line}</li>
        ))}
      </ul>
    </>
  );
}

function Work({ now }: { readonly now: ToothImport }) {
  if (now.state === "receiving")
    return <Progress label={say("tooth_import.sending")} share={now.received / now.bytes} />;
  return (
    <Progress
      label={now.phase === "" ? say("tooth_import.working") : say(`import_phase.${now.phase}`)}
      share={now.phase === "filling" ? now.share : undefined}
    />
  );
}
