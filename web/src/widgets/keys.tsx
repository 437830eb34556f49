import { useEffect, useRef, useState } from "preact/hooks";
import { say } from "../base/words";
import { Dialog } from "./dialog";
import { CheckField } from "./form";

// Single keys for repeated work. They act only while nothing is typed, and can be switched off,
// since a person who speaks to the computer, or slips, would set them off unwillingly (WCAG 2.1.4).

export interface Key {
  readonly key: string; // as KeyboardEvent.key has it; a small letter stands for the large one too
  readonly also?: string; // another that does the same
  readonly what: string;
  readonly act: () => void;
}

export interface Keys {
  readonly list: readonly Key[];
  readonly open: boolean; // the list of them is shown
  readonly setOpen: (open: boolean) => void;
}

const kOff = "enamel.keys_off";

function areOff(): boolean {
  try {
    return localStorage.getItem(kOff) !== null;
  } catch {
    return false;
  }
}

function setOff(off: boolean): void {
  try {
    if (off) localStorage.setItem(kOff, "1");
    else localStorage.removeItem(kOff);
  } catch {
    // They stay as they are where the browser keeps nothing.
  }
}

// "?" shows the list; it works also while the others are off.
export function useKeys(list: readonly Key[]): Keys {
  const [open, setOpen] = useState(false);
  const latest = useRef(list);
  latest.current = list;
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      if (
        event.defaultPrevented ||
        event.ctrlKey ||
        event.metaKey ||
        event.altKey ||
        isOthers(event.target, event.key) ||
        document.querySelector("dialog[open]") !== null
      )
        return;
      if (event.key === "?") {
        event.preventDefault();
        setOpen(true);
        return;
      }
      const key = areOff()
        ? undefined
        : latest.current.find((item) =>
            [event.key, event.key.toLowerCase()].some((pressed) => pressed === item.key || pressed === item.also),
          );
      if (key === undefined) return;
      event.preventDefault();
      key.act();
    };
    document.addEventListener("keydown", press);
    return () => document.removeEventListener("keydown", press);
  }, []);
  return { list, open, setOpen };
}

// Whether the key does something else where the focus is: everything does in a text, little does
// elsewhere.
function isOthers(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (
    target.isContentEditable ||
    target.matches("textarea, input:not([type=checkbox]):not([type=radio]):not([type=range])")
  )
    return true;
  if (key === " ") return target.matches("button, a, summary, select, input");
  if (target.matches("select")) return kMoves.has(key) || /^[0-9.]$/.test(key);
  return kMoves.has(key) && target.matches("input[type=radio], input[type=range], [role=tab], [role=menuitem]");
}
const kMoves: ReadonlySet<string> = new Set([
  "ArrowLeft",
  "ArrowRight",
  "ArrowUp",
  "ArrowDown",
  "Home",
  "End",
  "PageUp",
  "PageDown",
]);

const kNames: Readonly<Record<string, string>> = { ArrowLeft: "←", ArrowRight: "→" };
const nameOf = (key: string) => (key === " " ? say("keys.space") : (kNames[key] ?? key));

export function KeysHelp({ keys }: { readonly keys: Keys }) {
  const [off, setIsOff] = useState(areOff);
  return (
    <>
      <button type="button" class="button small quiet no-print" onClick={() => keys.setOpen(true)}>
        {say("keys.button")}
      </button>
      {keys.open && (
        <Dialog title={say("keys.title")} onClose={() => keys.setOpen(false)}>
          <dl class="facts stacked">
            {keys.list.map(({ key, also, what }) => (
              <div key={key}>
                <dt>{what}</dt>
                <dd>
                  <kbd>{nameOf(key)}</kbd>
                  {also !== undefined && (
                    <>
                      {" "}
                      <kbd>{nameOf(also)}</kbd>
                    </>
                  )}
                </dd>
              </div>
            ))}
            <div>
              <dt>{say("keys.this_list")}</dt>
              <dd>
                <kbd>?</kbd>
              </dd>
            </div>
          </dl>
          <CheckField
            label={say("keys.on")}
            value={!off}
            onValue={(on) => {
              setOff(!on);
              setIsOff(!on);
            }}
          />
          <div class="button-row end">
            <button type="button" class="button primary" onClick={() => keys.setOpen(false)}>
              {say("common.close")}
            </button>
          </div>
        </Dialog>
      )}
    </>
  );
}
