import { useEffect, useState } from "preact/hooks";
import { say } from "../../base/words";

export interface Slip {
  readonly display_name: string;
  readonly login: string;
  readonly password: string;
}

// Prints a slip for each person, to be cut apart and handed out: nothing else of the page.
export function PrintSlips({ slips }: { readonly slips: readonly Slip[] }) {
  const [printing, setPrinting] = useState(false);
  useEffect(() => {
    if (!printing) return undefined;
    const done = () => setPrinting(false);
    window.addEventListener("afterprint", done);
    window.print();
    return () => window.removeEventListener("afterprint", done);
  }, [printing]);
  return (
    <>
      <button type="button" class="button" onClick={() => setPrinting(true)}>
        {say("people.print_slips", { count: slips.length })}
      </button>
      {printing && (
        <div class="slips">
          {slips.map(({ display_name: name, login, password }) => (
            <div class="slip" key={login}>
              <p class="slip-name">{name}</p>
              <p>{say("people.slip_where", { address: window.location.origin })}</p>
              <p>
                {say("account.login")}: <code>{login}</code>
              </p>
              <p>
                {say("account.password")}: <code>{password}</code>
              </p>
              <p>{say("people.slip_once")}</p>
            </div>
          ))}
        </div>
      )}
    </>
  );
}
