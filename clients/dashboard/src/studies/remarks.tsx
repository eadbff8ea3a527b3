// What people say of a study: its title and notes, to be read and written.

import { useState } from "preact/hooks";

import { Problem, sendJson } from "../api/client";
import type { Comparison, Fault } from "../api/types";
import { Dialog } from "../ui/dialog";
import { sayFailure } from "../ui/toasts";

const kMostOfTitle = 200, kMostOfNotes = 20_000;

function Writing({ report, reload, onClose }: { report: Comparison; reload: () => void; onClose: () => void }) {
  const [title, setTitle] = useState(report.request.title ?? "");
  const [notes, setNotes] = useState(report.request.notes ?? "");
  const [faults, setFaults] = useState<Fault[]>([]);
  const [sending, setSending] = useState(false);
  const save = async () => {
    setSending(true);
    try {
      await sendJson("PATCH", `/v1/comparisons/${report.id}`, { title: title.trim() || null, notes: notes.trim() || null });
      reload();
      onClose();
    } catch (failure) {
      setSending(false);
      if (failure instanceof Problem && failure.faults.length > 0) setFaults(failure.faults);
      else sayFailure(failure);
    }
  };
  return (
    <Dialog title={`Title and notes of ${report.id}`} onClose={onClose}>
      <form
        class="stack study-remarks-form"
        onSubmit={(event) => {
          event.preventDefault();
          void save();
        }}
      >
        <label class="field">
          Title
          <input value={title} maxLength={kMostOfTitle} onInput={(event) => setTitle(event.currentTarget.value)} />
        </label>
        <label class="field">
          Notes
          <textarea rows={8} value={notes} maxLength={kMostOfNotes} onInput={(event) => setNotes(event.currentTarget.value)} />
        </label>
        {faults.map((fault) => (
          <p key={fault.pointer} class="fault">
            {fault.pointer.slice(1)}: {fault.detail}
          </p>
        ))}
        <div class="row">
          <button class="primary" disabled={sending}>
            {sending ? "Saving …" : "Save"}
          </button>
          <button type="button" onClick={onClose}>
            Leave it
          </button>
        </div>
      </form>
    </Dialog>
  );
}

export function Remarks({ report, reload }: { report: Comparison; reload: () => void }) {
  const [writing, setWriting] = useState(false);
  const { title, notes } = report.request;
  return (
    <div class="study-remarks">
      {notes && <p class="study-notes">{notes}</p>}
      <button class="small" onClick={() => setWriting(true)}>
        {title || notes ? "Change title and notes" : "Give it a title and notes"}
      </button>
      {writing && <Writing report={report} reload={reload} onClose={() => setWriting(false)} />}
    </div>
  );
}
