// Requests that are tried again before anything of a film is known. Later ones are of the store.

import { TransportError } from "../format/http.ts";

const TRIES = 5;
const DELAY_MS = 200;

/** What `act` answers, which is tried again where the server fails: after 0.2 s, and then twice as long each time. */
export async function withRetries<T>(act: () => Promise<T>): Promise<T> {
  for (let tried = 1; ; tried += 1) {
    try {
      return await act();
    } catch (error) {
      if (!(error instanceof TransportError) || tried === TRIES) {
        throw error;
      }
      await new Promise((resolve) => setTimeout(resolve, DELAY_MS * 2 ** (tried - 1)));
    }
  }
}
