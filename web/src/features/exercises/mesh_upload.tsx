import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { placedMessage } from "../../api/placed";
import type { ToothImport, ToothWanted } from "../../api/types";
import { say } from "../../base/words";
import { ErrorNotice, Progress } from "../../widgets/basics";
import { FileField, NumberField, SelectField } from "../../widgets/form";

const kPollMs = 700;
const kPartBytes = 512 * 1024; // of a mesh, in one request: the server takes 1 MiB
const kUnits = ["mm", "um", "cm", "m", "inch"] as const;
type Scale = (typeof kUnits)[number] | "factor" | "longest";

// Sends a mesh in parts, unless the server still keeps it from the import `mesh_of`, and asks until it is done or refused.
// `onChange` hears of each step. If the person leaves before all of it was sent, the server forgets the upload.
async function importMesh(
  client: Client,
  file: File,
  wanted: ToothWanted,
  onChange: (now: ToothImport) => void,
  signal: AbortSignal,
): Promise<ApiResult<ToothImport>> {
  const body = { file_name: file.name, bytes: file.size, ...wanted };
  let now: ApiResult<ToothImport> = await client.post("/tooth-imports", { body });
  if (!now.ok && now.error.field === "mesh_of")
    now = await client.post("/tooth-imports", { body: { ...body, mesh_of: null } });
  while (now.ok) {
    const { id, state, received: offset } = now.value;
    if (signal.aborted) {
      if (state === "receiving") await client.delete("/tooth-imports/{id}", { id });
      return now;
    }
    onChange(now.value);
    if (state === "done" || state === "refused") return now;
    if (state === "receiving") {
      const part = file.slice(offset, offset + kPartBytes);
      now = await client.put("/tooth-imports/{id}/bytes", { id, offset, body: part, type: "application/octet-stream" });
    } else {
      await new Promise((done) => setTimeout(done, kPollMs));
      now = await client.get("/tooth-imports/{id}", { id });
    }
  }
  return now;
}

export type MeshWanted = Omit<ToothWanted, "unit" | "scale" | "longest_mm" | "mesh_of">;

// A mesh that somebody chooses, says the scale of, and sends.
export function useMeshUpload(client: Client) {
  const [file, setFile] = useState<File>();
  const [scale, setScale] = useState<Scale>("mm");
  const [factor, setFactor] = useState(1);
  const [longest, setLongest] = useState(10);
  const [now, setNow] = useState<ToothImport>();
  const [refused, setRefused] = useState<string>();
  const sentBefore = useRef<{ readonly file: File; readonly id: string } | undefined>(undefined);
  const leaving = useRef(new AbortController());
  useEffect(() => () => leaving.current.abort(), []);
  const busy = now !== undefined && (now.state === "receiving" || now.state === "working");

  // What became of it; undefined where it was not accepted, or where the person left.
  const send = async (wanted: MeshWanted): Promise<ToothImport | undefined> => {
    if (file === undefined || busy) return undefined;
    setRefused(undefined);
    const before = sentBefore.current;
    const about = {
      ...wanted,
      mesh_of: before?.file === file ? before.id : null,
      unit: scale === "factor" || scale === "longest" ? ("mm" as const) : scale,
      ...(scale === "factor" ? { scale: factor } : {}),
      ...(scale === "longest" ? { longest_mm: longest } : {}),
    };
    const sent = await importMesh(client, file, about, setNow, leaving.current.signal);
    if (leaving.current.signal.aborted) return undefined;
    sentBefore.current = sent.ok ? { file, id: sent.value.id } : undefined;
    setNow(sent.ok ? sent.value : undefined);
    if (!sent.ok) setRefused(placedMessage(sent.error));
    return sent.ok ? sent.value : undefined;
  };

  const fields = (label: string) => (
    <>
      <FileField label={label} accept=".stl,.ply,.obj,.off" onFile={setFile} hint={say("tooth_import.mesh_hint")} />
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
          max={200}
          step="any"
          hint={say("tooth_import.longest_hint")}
        />
      )}
    </>
  );
  const problems = (
    <>
      {refused !== undefined && <ErrorNotice title={say("tooth_import.refused")} message={refused} />}
      {now?.state === "refused" && now.problem !== null && (
        <ErrorNotice title={say("tooth_import.impossible")} message={now.problem.message} />
      )}
      <div aria-live="polite">{busy && <Work now={now} />}</div>
    </>
  );
  return { file, now, busy, send, fields, problems };
}

export function Findings({ lines }: { readonly lines: readonly string[] }) {
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
