import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed } from "../../api/http";
import type { ListedDevice } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Badge, Brief, Card, Empty, ErrorNotice, Waits } from "../../widgets/basics";
import { needed } from "../../widgets/button";
import { Confirm, Dialog, FormButtons } from "../../widgets/dialog";
import { TextField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";

const kLongest = 128;

// Haptic devices that graded work and exams are done with, unless the assignment allows more.
export function ListedDevices({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const { loaded, reload } = useRequest("devices", (signal) => client.get("/listed-devices", { signal }));
  const [open, setOpen] = useState<"add" | ListedDevice>();
  const close = () => setOpen(undefined);
  return (
    <Card
      title={say("listed.title")}
      aside={
        admin && (
          <button type="button" class="button" onClick={() => setOpen("add")}>
            {say("listed.add_ask")}
          </button>
        )
      }
    >
      <p class="hint">{say("listed.hint")}</p>
      <Waits loaded={loaded} reload={reload} what={say("loading.devices")} failed={say("listed.failed")} />
      {loaded.state === "ready" &&
        (loaded.value.devices.length === 0 ? (
          <Empty>{say("listed.none")}</Empty>
        ) : (
          <DataTable
            label={say("listed.title")}
            items={[...loaded.value.devices]}
            rowKey={(device) => device.name}
            dense
            columns={[
              {
                title: say("common.device"),
                cell: ({ title, shook_ms }) => (
                  <>
                    {title}{" "}
                    {shook_ms > 0 && (
                      <Badge tone="warning">{say("listed.shook", { date: formatDateTime(shook_ms) })}</Badge>
                    )}
                  </>
                ),
              },
              { title: say("listed.known_by"), cell: (device) => <code>{device.name}</code> },
              { title: say("listed.since"), cell: (device) => formatDateTime(device.added_ms) },
              ...(admin
                ? [
                    {
                      title: say("common.change"),
                      hideTitle: true,
                      cell: (device: ListedDevice) => (
                        <div class="row-tools">
                          <button type="button" class="button small" onClick={() => setOpen(device)}>
                            <Brief
                              shown={say("cohort.remove_ask")}
                              full={say("cohort.remove_whom", { name: device.title })}
                            />
                          </button>
                        </div>
                      ),
                    },
                  ]
                : []),
            ]}
          />
        ))}
      {open === "add" && <Add client={client} onClose={close} onDone={reload} />}
      {open !== undefined && open !== "add" && (
        <Confirm
          title={say("listed.remove_title", { name: open.title })}
          action={say("common.remove")}
          onClose={close}
          onConfirm={() => failed(client.post("/listed-devices/remove", { body: { name: open.name } }), reload)}
        >
          <p>{say("listed.remove_text")}</p>
        </Confirm>
      )}
    </Card>
  );
}

function Add({
  client,
  onClose,
  onDone,
}: {
  readonly client: Client;
  readonly onClose: () => void;
  readonly onDone: () => void;
}) {
  const [name, setName] = useState("");
  const [title, setTitle] = useState("");
  const change = useChange();
  const problemOf = (field: string) => (change.error?.field === field ? change.error.message : undefined);
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.post("/listed-devices", { body: { name: name.trim(), title: title.trim() } }),
    );
    if (result?.ok !== true) return;
    onDone();
    onClose();
  };
  return (
    <Dialog title={say("listed.add_title")} onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("listed.known_by")}
          hint={sayWith("listed.known_hint", { command: <code>"enamel-station devices"</code> })}
          value={name}
          onValue={setName}
          required
          maxLength={kLongest}
          problem={problemOf("name")}
        />
        <TextField
          label={say("account.name")}
          hint={say("listed.name_hint")}
          value={title}
          onValue={setTitle}
          required
          maxLength={kLongest}
          problem={problemOf("title")}
        />
        {change.error !== undefined && problemOf("name") === undefined && problemOf("title") === undefined && (
          <ErrorNotice title={say("common.not_added")} message={change.error.message} />
        )}
        <FormButtons
          action={say("common.add")}
          busy={change.busy}
          blocked={needed({ [say("listed.known_by")]: name.trim(), [say("account.name")]: title.trim() })}
          onCancel={onClose}
        />
      </form>
    </Dialog>
  );
}
