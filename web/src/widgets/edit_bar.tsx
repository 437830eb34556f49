import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { say, sayWith } from "../base/words";
import { Notice } from "./basics";
import { Button } from "./button";
import type { EditedDocument } from "./use_document";

// Undo, redo and what ends the edit; stays in sight. Ctrl+Z and Ctrl+Y act where no text is typed:
// a field has its own.
export function EditBar({
  edit,
  state,
  children,
}: {
  readonly edit: EditedDocument;
  readonly state: string;
  readonly children: ComponentChildren;
}) {
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      if (
        !(event.ctrlKey || event.metaKey) ||
        event.target instanceof HTMLInputElement ||
        event.target instanceof HTMLTextAreaElement
      )
        return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      if (key === "y" || event.shiftKey) edit.redo();
      else edit.undo();
    };
    document.addEventListener("keydown", press);
    return () => document.removeEventListener("keydown", press);
  });
  return (
    <>
      {edit.kept && (
        <Notice tone="neutral" title={say("edit.kept")}>
          <p>
            {sayWith("edit.kept_unsaved", {
              discard: (
                <button type="button" class="button small" onClick={edit.discard}>
                  {say("edit.discard")}
                </button>
              ),
            })}
          </p>
        </Notice>
      )}
      <div class="edit-bar">
        <span class="hint" role="status">
          {state}
        </span>
        <div class="button-row">
          <Button
            kind=""
            blocked={edit.canUndo ? undefined : say("edit.no_undo")}
            tip={say("edit.undo")}
            onClick={edit.undo}
          >
            {say("edit.undo")}
          </Button>
          <Button
            kind=""
            blocked={edit.canRedo ? undefined : say("edit.no_redo")}
            tip={say("edit.redo")}
            onClick={edit.redo}
          >
            {say("edit.redo")}
          </Button>
          {children}
        </div>
      </div>
    </>
  );
}
