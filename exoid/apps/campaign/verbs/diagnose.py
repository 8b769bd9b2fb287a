"""`exoid diagnose` in a campaign: the effect that is missing."""

from exoid.apps.campaign.verb import CampaignVerb

VERB = CampaignVerb()
