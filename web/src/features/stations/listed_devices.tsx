import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ListedDevice } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { Card, Empty, ErrorNotice, Loading } from "../../widgets/basics";
import { Confirm, Dialog, FormButtons } from "../../widgets/dialog";
import { TextField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";

const kLongest = 128;

// Haptic devices that graded work and exams are done with, unless the assignment allows more.
export function ListedDevices({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const { loaded, reload } = useRequest("devices", (signal) => client.stations.devices(signal));
  const [open, setOpen] = useState<"add" | ListedDevice>();
  const close = () => setOpen(undefined);
  return (
    <Card title="Devices for graded work"
          aside={admin && <button type="button" class="button" onClick={() => setOpen("add")}>Add a device…</button>}>
      <p class="hint">Graded work and exams are done with these, unless the assignment allows more.</p>
      {loaded.state === "loading" && <Loading what="the devices" />}
      {loaded.state === "failed" && <ErrorNotice title="The devices could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.devices.length === 0 ? <Empty>No device is listed yet.</Empty> : (
        <DataTable label="Devices for graded work" items={[...loaded.value.devices]} rowKey={(device) => device.name} dense columns={[
          { title: "Device", cell: (device) => device.title },
          { title: "Known by", cell: (device) => <code>{device.name}</code> },
          { title: "Since", cell: (device) => formatDateTime(device.added_ms) },
          ...(admin ? [{ title: "Change", hideTitle: true, cell: (device: ListedDevice) => (
            <div class="row-tools"><button type="button" class="button small" onClick={() => setOpen(device)}>Remove…<span class="hidden"> {device.title}</span></button></div>) }] : []),
        ]} />
      ))}
      {open === "add" && <Add client={client} onClose={close} onDone={reload} />}
      {open !== undefined && open !== "add" && (
        <Confirm title={`Remove ${open.title} from the list?`} action="Remove" onClose={close}
                 onConfirm={async () => {
                   const result = await client.stations.unlistDevice(open.name);
                   if (!result.ok) return result.error.message;
                   reload();
                   return undefined;
                 }}>
          <p>Graded work cannot begin with it any more, unless the assignment allows it. What was done with it stays.</p>
        </Confirm>
      )}
    </Card>
  );
}

function Add({ client, onClose, onDone }: { readonly client: Client; readonly onClose: () => void; readonly onDone: () => void }) {
  const [name, setName] = useState("");
  const [title, setTitle] = useState("");
  const change = useChange();
  const problemOf = (field: string) => change.error?.field === field ? change.error.message : undefined;
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.stations.listDevice(name.trim(), title.trim()));
    if (result?.ok !== true) return;
    onDone();
    onClose();
  };
  return (
    <Dialog title="Add a device" onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField label="Known by" hint={<>What <code>enamel-station devices</code> shows for it, such as hid:1209:0001:A7; its model where it has no number of its own.</>}
                   value={name} onValue={setName} required maxLength={kLongest} problem={problemOf("name")} />
        <TextField label="Name" hint="For people: chair 3" value={title} onValue={setTitle} required maxLength={kLongest} problem={problemOf("title")} />
        {change.error !== undefined && problemOf("name") === undefined && problemOf("title") === undefined && <ErrorNotice title="Not added" message={change.error.message} />}
        <FormButtons action="Add" disabled={change.busy || name.trim() === "" || title.trim() === ""} onCancel={onClose} />
      </form>
    </Dialog>
  );
}
