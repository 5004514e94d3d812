// Elements of index.html. Text from a film goes into pages only through `textContent`.

/** The element of this id, which index.html has. */
export function byId<T extends Element>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) {
    throw new Error(`index.html has no ${type.name} named ${id}`);
  }
  return found;
}

/** A button of index.html, with what it does. */
export function onPress(id: string, act: () => void): HTMLButtonElement {
  const button = byId(id, HTMLButtonElement);
  button.addEventListener("click", act);
  return button;
}

/** Changes the text of an element only where it is another, so that selections stay. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) {
    element.textContent = text;
  }
}

/** Rows of text. The first cell of each heads the row; others that look like numbers stand at the right. */
export function setRows(body: HTMLTableSectionElement, rows: readonly (readonly string[])[]): void {
  while (body.rows.length > rows.length) {
    body.deleteRow(-1);
  }
  rows.forEach((texts, at) => {
    const row = body.rows[at] ?? body.insertRow();
    texts.forEach((text, column) => {
      let cell = row.cells[column];
      if (cell === undefined) {
        cell = row.appendChild(document.createElement(column === 0 ? "th" : "td"));
        if (column === 0) {
          cell.scope = "row";
        }
      }
      setText(cell, text);
      cell.classList.toggle("number", column > 0 && /^[\d-]/.test(text));
    });
  });
}

const DIGITS = new Intl.NumberFormat("en-US", { maximumFractionDigits: 2 });

/** A number with its thousands apart, and up to two digits behind the point. */
export function numberText(value: number): string {
  return DIGITS.format(value);
}

/** Bytes in a unit that leaves up to three digits before the point: 1 kB is 1000 bytes. */
export function byteText(bytes: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 ? value : value.toPrecision(3)} ${units[unit]}`;
}

/** Milliseconds with one digit behind the point. */
export function msText(ms: number): string {
  return `${ms.toFixed(1)} ms`;
}

/** Text with a full stop at its end. */
export function sentence(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

/** Text without a full stop at its end. */
export function clause(text: string): string {
  return text.replace(/\.$/, "");
}

/** Puts text on the clipboard and says so on the button. Where the clipboard is closed to the page, `code` is selected for the viewer to copy. */
export async function copyText(text: string, button: HTMLButtonElement, code?: Element): Promise<void> {
  const label = button.querySelector("span") ?? button;
  const usual = (button.dataset.text ??= label.textContent ?? "");
  let said = "Copied";
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    said = "Press Ctrl+C";
    if (code !== undefined) {
      getSelection()?.selectAllChildren(code);
    } else {
      said = "Copy the address";
    }
  }
  label.textContent = said;
  // Where buttons show icons alone, this one shows its text meanwhile.
  button.classList.add("says");
  setTimeout(() => {
    label.textContent = usual;
    button.classList.remove("says");
  }, 1500);
}

/** What an error says. */
export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
