import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";
import { Button } from "./button";
import { say } from "../base/words";
import { ErrorNotice, type Tone } from "./basics";

interface DialogProps {
  readonly title: string;
  readonly children: ComponentChildren;
  readonly onClose: () => void; // Escape, or the button that closes
  readonly wide?: boolean;
}

// A modal dialog: the browser keeps the focus inside, Escape closes it, and the focus goes back to
// where it was.
export function Dialog({ title, children, onClose, wide = false }: DialogProps) {
  const dialog = useRef<HTMLDialogElement>(null);
  const id = useId();
  useEffect(() => {
    const before = document.activeElement;
    dialog.current?.showModal();
    return () => {
      if (before instanceof HTMLElement && before.isConnected) before.focus();
    };
  }, []);
  return (
    <dialog
      ref={dialog}
      class={wide ? "dialog wide" : "dialog"}
      aria-labelledby={id}
      onCancel={(event) => {
        event.preventDefault();
        onClose();
      }}
      onClose={onClose}
    >
      <h2 id={id}>{title}</h2>
      {children}
    </dialog>
  );
}

interface ConfirmProps {
  readonly title: string;
  readonly children: ComponentChildren; // what will happen, and whether it can be undone
  readonly action: string; // what the button says
  readonly tone?: Extract<Tone, "bad" | "neutral">;
  readonly onConfirm: () => Promise<string | undefined>; // the reason when it failed
  readonly onClose: () => void;
}

// Asks before something that is not easily undone. Stays open with the reason when it failed.
export function Confirm({ title, children, action, tone = "bad", onConfirm, onClose }: ConfirmProps) {
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState<string>();
  const confirm = async () => {
    if (busy) return;
    setBusy(true);
    const reason = await onConfirm();
    setBusy(false);
    setProblem(reason);
    if (reason === undefined) onClose();
  };
  return (
    <Dialog title={title} onClose={onClose}>
      {children}
      {problem !== undefined && <ErrorNotice title={say("common.not_done")} message={problem} />}
      <div class="button-row end">
        <button type="button" class="button" onClick={onClose}>
          {say("common.cancel")}
        </button>
        <button
          type="button"
          class={`button ${tone === "bad" ? "danger" : "primary"}`}
          disabled={busy}
          onClick={() => void confirm()}
        >
          {action}
        </button>
      </div>
    </Dialog>
  );
}

interface FormButtonsProps {
  readonly action: string; // what the button that sends the form says
  readonly busy: boolean;
  readonly blocked?: string | undefined; // why it cannot be sent yet
  readonly onCancel: () => void;
}

// The last row of a form in a dialog.
export function FormButtons({ action, busy, blocked, onCancel }: FormButtonsProps) {
  return (
    <div class="button-row end">
      <button type="button" class="button" onClick={onCancel}>
        {say("common.cancel")}
      </button>
      <Button busy={busy} blocked={blocked}>
        {action}
      </Button>
    </div>
  );
}
