// The script of pages with an arm: a live session, or runs on a time axis.

import { showSession } from './live.js';
import { showRuns } from './runs.js';

const element = (id) => document.getElementById(id);
const data = (id) => JSON.parse(element(id).textContent);
if (element('live')) showSession(element('live'), data('live-data'));
else showRuns(element('viewer'), data('viewer-data'));
