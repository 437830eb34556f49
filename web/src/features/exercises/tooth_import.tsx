import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { placedMessage } from "../../api/placed";
import type { ToothImport, ToothImportUnit } from "../../api/types";
import { say } from "../../base/words";
import { ErrorNotice, Notice, Progress } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { FileField, SelectField, TextField } from "../../widgets/form";
import { BuiltinTooth } from "./builtin_tooth";

const kPollMs = 700;
const kUnits: ReadonlyArray<{ readonly value: ToothImportUnit; readonly title: string }> = [
  {
    value: "mm",
    get title() {
      return say("length_unit.mm");
    },
  },
  {
    value: "um",
    get title() {
      return say("length_unit.um");
    },
  },
  {
    value: "cm",
    get title() {
      return say("length_unit.cm");
    },
  },
  {
    value: "m",
    get title() {
      return say("length_unit.m");
    },
  },
  {
    value: "inch",
    get title() {
      return say("length_unit.inch");
    },
  },
];
// ISO 3950, quadrant by quadrant: permanent teeth, then deciduous ones.
const kTeeth = [1, 2, 3, 4, 5, 6, 7, 8].flatMap((quadrant) =>
  [1, 2, 3, 4, 5, 6, 7, 8].slice(0, quadrant <= 4 ? 8 : 5).map((tooth) => `${quadrant}${tooth}`),
);
const kPhases: Readonly<Record<string, string>> = {
  get reading() {
    return say("import_phase.reading");
  },
  get repairing() {
    return say("import_phase.repairing");
  },
  get placing() {
    return say("import_phase.placing");
  },
  get tissues() {
    return say("import_phase.tissues");
  },
  get filling() {
    return say("import_phase.filling");
  },
  get storing() {
    return say("import_phase.storing");
  },
};

interface Props {
  readonly client: Client;
  readonly onDone: () => void; // a tooth is there
  readonly onClose: () => void;
}

// A built-in tooth, or a mesh of the admin's, with its exercises.
export function AddTooth(props: Props) {
  return (
    <>
      <BuiltinTooth client={props.client} onDone={props.onDone} />
      <h3>{say("tooth_import.own")}</h3>
      <ToothImportForm {...props} />
    </>
  );
}

function ToothImportForm({ client, onDone, onClose }: Props) {
  const [file, setFile] = useState<File>();
  const [title, setTitle] = useState("");
  const [unit, setUnit] = useState<ToothImportUnit>("mm");
  const [tooth, setTooth] = useState("");
  const [now, setNow] = useState<ToothImport>();
  const [refused, setRefused] = useState<string>();
  const leaving = useRef(new AbortController());
  useEffect(() => () => leaving.current.abort(), []);
  const busy = now !== undefined && (now.state === "receiving" || now.state === "working");

  const send = async (event: Event) => {
    event.preventDefault();
    if (file === undefined || busy) return;
    setRefused(undefined);
    const sent = await client.operations.importTooth(
      file,
      { unit, title: title.trim(), tooth: Number(tooth) },
      setNow,
      kPollMs,
      leaving.current.signal,
    );
    if (leaving.current.signal.aborted) return;
    if (!sent.ok) {
      setNow(undefined);
      setRefused(placedMessage(sent.error));
      return;
    }
    setNow(sent.value);
    if (sent.value.state === "done") onDone();
  };

  if (now?.state === "done" && now.tooth !== null) {
    return (
      <>
        <Notice tone="good" title={now.tooth.title}>
          <p>{say("tooth_import.published", { count: now.tooth.exercises.length })}</p>
        </Notice>
        <h3>{say("tooth_import.found")}</h3>
        <ul>
          {now.findings.map((line) => (
            <li key={line}>{line}</li>
          ))}
        </ul>
        <div class="button-row">
          <button type="button" class="button primary" onClick={onClose}>
            {say("common.close")}
          </button>
        </div>
      </>
    );
  }
  return (
    <form class="form" onSubmit={(event) => void send(event)}>
      <FileField
        label={say("tooth_import.mesh")}
        accept=".stl,.ply,.obj,.off"
        onFile={setFile}
        hint={say("tooth_import.mesh_hint")}
      />
      <SelectField label={say("tooth_import.unit")} value={unit} onValue={setUnit} options={kUnits} />
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
      {refused !== undefined && <ErrorNotice title={say("tooth_import.refused")} message={refused} />}
      {now?.state === "refused" && now.problem !== null && (
        <ErrorNotice title={say("tooth_import.impossible")} message={now.problem.message} />
      )}
      <div aria-live="polite">{busy && <Work now={now} />}</div>
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
          {say("tooth_import.import")}
        </Button>
      </div>
    </form>
  );
}

function Work({ now }: { readonly now: ToothImport }) {
  if (now.state === "receiving")
    return <Progress label={say("tooth_import.sending")} share={now.received / now.bytes} />;
  return (
    <Progress
      label={kPhases[now.phase] ?? say("tooth_import.working")}
      share={now.phase === "filling" ? now.share : undefined}
    />
  );
}
